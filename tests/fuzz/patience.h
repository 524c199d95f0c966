/* Waits for other threads of this process to say something, without mistaking a stalled machine for a stalled program.
 *
 * A clock on the wall cannot tell the two apart. Once in 34 403 inputs, on a machine with four busy programs on its two
 * processors, an honest request to the fuzzed service had no answer after 5 s, and no repetition showed why; the same run
 * had two inputs of more than 10 s that broke no promise. A process that is stopped for those 5 s (SIGSTOP, a paused virtual
 * machine) while its reader is in poll() fails in the same way: the time-out has passed before any thread ran again. So what
 * is counted here is what the process could have used:
 *
 *   it hangs   when in many looks, one after a slice of time each, every other thread was asleep of its own will (state S):
 *              nobody computed, wanted a processor (R), or waited for a disk (D)
 *   it spins   when the other threads have used so much processor time
 *
 * All else is the machine's: such slices do not count, however many they are. Whoever calls has an alarm clock for the case
 * that they never end (libFuzzer's -timeout, plain_main.c's PATIENCE_S).
 */
#ifndef QG_TESTS_FUZZ_PATIENCE_H
#define QG_TESTS_FUZZ_PATIENCE_H

/* How long the others may be asleep, and how long they may compute: ms. */
struct patience {
    int asleep, computing;
};

enum verdict { PATIENCE_READY, PATIENCE_HANGS, PATIENCE_SPINS };

/* Waits until a descriptor can be read (or is at its end), or the patience is over. */
enum verdict patience_wait(int descriptor, const struct patience *patience);

/* Prints each thread's name, state and place in the kernel to stderr. */
void patience_print_threads(void);

#endif
