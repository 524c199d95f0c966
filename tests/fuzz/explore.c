/* What libFuzzer is given beside a harness: every other mutation is one of ours, which knows numbers and words. */
#include "tests/fuzz/fuzz.h"

/* libFuzzer's names: its own mutator, and the hook for another one. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t room);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned int seed);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t room, unsigned int seed) {
    if (seed % 2)
        return LLVMFuzzerMutate(data, size, room);
    return fuzz_mutate(data, size, room, (const uint64_t[2]){seed, 0});
}
