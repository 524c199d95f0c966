// What a job's design looks like: the teeth in mesh, the profile diagram beside the reference's, and DXF to take away.
import { useState } from "preact/hooks";
import { getJobDxf, getJobProfile } from "../api.js";
import { nameIn } from "../drawings/files.js";
import { ReliefDrawing } from "../drawings/relief.jsx";
import { TeethDrawing } from "../drawings/teeth.jsx";
import { jobTitle } from "../format.js";
import { Panel, complain, useLoaded } from "../parts/parts.jsx";
import { download, fileName } from "../plots/picture.js";

async function saveDxf(job, extent, position) {
  try {
    const response = await getJobDxf(job.id, { extent, position });
    download(`${fileName(jobTitle(job))}-${nameIn(response, `${extent}.dxf`)}`, await response.blob());
  } catch (problem) {
    complain(problem);
  }
}

// The profile data of the design, and of the reference where it is another one.
function useProfiles(job, hasReference) {
  const of = (design) => (signal) => getJobProfile(job.id, design, signal);
  const { value: profile } = useLoaded(of("design"), [job.id]);
  const { value: reference } = useLoaded(hasReference ? of("reference") : () => Promise.resolve(null), [job.id, hasReference]);
  return { profile, reference };
}

// The profile diagram alone, for paper.
export function JobRelief({ job, hasReference }) {
  const { profile, reference } = useProfiles(job, hasReference);
  return profile && <ReliefDrawing profile={profile} reference={reference} />;
}

export function JobDrawings({ job, hasReference }) {
  const { profile, reference } = useProfiles(job, hasReference);
  const [position, setPosition] = useState(0.5);
  if (!profile) return null;
  return (
    <>
      <Panel title="Profile diagram" note="what is removed, normal to the involute" id="profile-diagram">
        <ReliefDrawing profile={profile} reference={reference} name={jobTitle(job)} />
      </Panel>
      <Panel title="Teeth in mesh" note="true scale">
        <TeethDrawing profile={profile} onPosition={setPosition} name={jobTitle(job)} />
        <p class="buttons">
          <button type="button" onClick={() => saveDxf(job, "gears", position)}>
            DXF, both gears
          </button>
          <button type="button" onClick={() => saveDxf(job, "spaces", position)}>
            DXF, tooth spaces
          </button>
        </p>
      </Panel>
    </>
  );
}
