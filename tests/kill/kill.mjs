// The kill campaign: node kill.mjs --rounds N [--seed S]                      (make kill KILL_ROUNDS=200)
// Writes its figures for docs/reliability.md; exit status 1 when anything was lost, doubled or changed.
import { beginSection, row, text } from "../load/drive.mjs";
import { campaign } from "./campaign.mjs";

const option = (name, standard) => {
  const at = process.argv.indexOf(name);
  return at > 0 ? Number(process.argv[at + 1]) : standard;
};

const rounds = option("--rounds", 200);
const seed = option("--seed", 1);
const tell = (round, jobs) => round % 10 === 0 && console.error(`${round} kills, ${jobs} jobs`);
const figures = await campaign({ rounds, seed, tell });
beginSection("kill");
text(
  `\`make kill KILL_ROUNDS=${rounds}\`: a daemon that submits, claims, evaluates, finishes and delivers webhooks is killed by SIGKILL ` +
    "at random moments and started again. After each kill the database as it lies there has to pass `PRAGMA integrity_check`; in the end " +
    "every accepted job has to have succeeded once, with the bits of an undisturbed run (`tests/kill/campaign.mjs` says how that is seen).",
);
row({
  kills: figures.rounds,
  "while jobs ran": figures.met.running,
  "while jobs waited": figures.met.queued,
  "while deliveries were pending": figures.met.delivering,
  "jobs accepted": figures.jobs,
  "submissions repeated for want of an answer": figures.repeated,
  "submissions repeated all the same": figures.again,
  attempts: figures.attempts,
  "lost, doubled, changed or damaged": figures.wrong.length,
});
for (const words of figures.wrong) console.error(words);
process.exit(figures.wrong.length ? 1 : 0);
