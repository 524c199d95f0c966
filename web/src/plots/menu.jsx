// The menu in the corner of a panel by which its plot or drawing is taken away as files.

// title: what the picture shows; files: pairs of a format's name and what saves the file; isOff: nothing can be taken now;
// children: buttons that stand before them.
export function FileMenu({ title, files, isOff = false, children }) {
  return (
    <span class="menu">
      {children}
      {files.map(([format, save]) => (
        <button type="button" class="quiet" key={format} onClick={save} disabled={isOff} aria-label={`${title} as ${format}`}>
          {format}
        </button>
      ))}
    </span>
  );
}
