// The document as JSON, to be edited. While the text is no JSON, the place where it breaks is named and the form keeps what
// it had.
import { useRef } from "preact/hooks";
import { setText } from "./draft.js";

export function Editor({ text, error }) {
  const area = useRef(null);
  const goThere = () => {
    area.current.focus();
    area.current.setSelectionRange(error.offset, Math.min(error.offset + 1, text.length));
    const height = area.current.scrollHeight / Math.max(1, text.split("\n").length);
    area.current.scrollTop = Math.max(0, (error.line - 4) * height);
  };
  return (
    <div class="editor">
      <textarea
        ref={area}
        class="code"
        aria-label="Job document, JSON"
        aria-invalid={Boolean(error) || undefined}
        aria-describedby="editor-error"
        spellcheck={false}
        autocomplete="off"
        wrap="off"
        value={text}
        onInput={(event) => setText(event.target.value)}
      />
      <p id="editor-error" class="fault" role="status" hidden={!error}>
        {error && (
          <>
            Line {error.line}, column {error.column}: {error.message}
            <button type="button" class="quiet" onClick={goThere}>
              Show
            </button>
          </>
        )}
      </p>
    </div>
  );
}
