// What the campaigns over disk and memory share: rounds run side by side, and what came of them in figures.
import { availableParallelism } from "node:os";

// Runs one(task) for each task, twice as many at a time as there are processors, for they wait a lot; the answers in the order of the tasks.
export async function eachOf(tasks, one, tell = () => {}) {
  const answers = new Array(tasks.length);
  let next = 0;
  let done = 0;
  const work = async () => {
    while (next < tasks.length) {
      const at = next++;
      answers[at] = await one(tasks[at], at);
      tell(++done, tasks.length, answers[at]);
    }
  };
  await Promise.all(Array.from({ length: 2 * availableParallelism() }, work));
  return answers;
}

// Every stride-th, beginning with that at `first`.
export const everyNth = (list, { stride = 1, first = 0 }) => list.filter((_, at) => at % stride === first);

// Counts the endings by kind: {kind: number}. Each of `kinds` is there.
export function tally(endings, kinds) {
  const counts = Object.fromEntries(kinds.map((kind) => [kind, 0]));
  for (const { ending } of endings) counts[ending]++;
  return counts;
}

// A progress line now and then, and at once what went wrong.
export const progress = (name) => {
  const start = Date.now();
  let last = start;
  return (done, all, { wrong }) => {
    for (const words of wrong) console.error(`${name}: ${words}`);
    if (done < all && Date.now() - last < 10000) return;
    last = Date.now();
    console.error(`${name}: ${done} of ${all} rounds, ${Math.round((last - start) / 1000)} s`);
  };
};
