// The form of a new job.
export function NewJob() {
  return (
    <>
      <h1>New job</h1>
      <p>The form is on its way.</p>
    </>
  );
}
