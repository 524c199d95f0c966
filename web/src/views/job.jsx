// One job.
import { useLoaded } from "../parts/parts.jsx";
import { getJob } from "../api.js";
import { jobTitle } from "../format.js";

export function Job({ id }) {
  const { value: job } = useLoaded((signal) => getJob(id, signal), [id]);
  return job && <h1>{jobTitle(job)}</h1>;
}
