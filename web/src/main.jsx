// The page's frame: heading, navigation, the state of the connection, and the view that the address names.
import { render } from "preact";
import { useEffect, useState } from "preact/hooks";
import { setToken } from "./api.js";
import { connection, followJobs } from "./jobs.js";
import { Notice } from "./parts/parts.jsx";
import { href, route } from "./router.js";
import { useStore } from "./store.js";
import { switchTheme, theme } from "./theme.js";
import { Compare } from "./views/compare.jsx";
import { Job } from "./views/job.jsx";
import { Jobs } from "./views/jobs.jsx";
import { NewJob } from "./views/new.jsx";

const CONNECTION_TEXT = {
  live: "live",
  connecting: "connecting…",
  lost: "no connection, trying again…",
};

function ConnectionMark() {
  const { state, problem } = useStore(connection);
  return (
    <span class={`connection ${state}`} role="status" title={problem ? problem.message : "The page follows the daemon"}>
      {CONNECTION_TEXT[state]}
    </span>
  );
}

// Asks for a token where the server wants one.
function TokenForm() {
  const { problem } = useStore(connection);
  const [token, setText] = useState("");
  if (problem?.status !== 401 && problem?.status !== 403) return null;
  const submit = (event) => {
    event.preventDefault();
    setToken(token.trim());
    location.reload();
  };
  return (
    <form class="token panel" onSubmit={submit}>
      <label>
        This server asks for a token
        <input
          type="password"
          value={token}
          onInput={(event) => setText(event.target.value)}
          autocomplete="off"
          required
        />
      </label>
      <button type="submit">Use it</button>
      <small>{problem.message}</small>
    </form>
  );
}

function Navigation({ current }) {
  const links = [
    ["jobs", "Jobs"],
    ["new", "New job"],
    ["compare", "Compare"],
  ];
  return (
    <nav aria-label="Views">
      {links.map(([path, text]) => (
        <a key={path} href={href(path)} aria-current={current === path ? "page" : undefined}>
          {text}
        </a>
      ))}
    </nav>
  );
}

function Header({ current }) {
  const shown = useStore(theme);
  return (
    <header class="top">
      <a class="brand" href={href("jobs")}>
        <img src="/assets/icon.svg" alt="" width="22" height="22" />
        quietgear
      </a>
      <Navigation current={current} />
      <span class="spread" />
      <ConnectionMark />
      <button
        type="button"
        class="quiet"
        onClick={switchTheme}
        aria-label={`Switch to ${shown === "dark" ? "light" : "dark"}`}
      >
        {shown === "dark" ? "☀" : "☾"}
      </button>
    </header>
  );
}

const TITLES = { jobs: "Jobs", new: "New job", compare: "Compare" };

function View({ path, query }) {
  const [view = "jobs", id, part] = path;
  if (view === "jobs" && id) return <Job key={id} id={id} isReport={part === "report"} />;
  if (view === "jobs") return <Jobs query={query} />;
  if (view === "new") return <NewJob query={query} />;
  if (view === "compare") return <Compare query={query} />;
  return <p>There is no such view.</p>;
}

function Page() {
  const { path, query } = useStore(route);
  const [view = "jobs", id, part] = path;
  const isReport = part === "report";
  useEffect(() => {
    document.title = id ? "quietgear" : `${TITLES[view] || "quietgear"} – quietgear`;
    document.getElementById("main")?.focus({ preventScroll: true });
    scrollTo(0, 0);
  }, [view, id]);
  useEffect(() => {
    if (!isReport) followJobs(); // a report stands still, and prints without waiting for a stream
  }, [isReport]);
  return (
    <>
      {!isReport && <Header current={id ? "" : view} />}
      <main id="main" tabIndex={-1} class={isReport ? "report" : ""}>
        <Notice />
        <TokenForm />
        <View path={path} query={query} />
      </main>
    </>
  );
}

render(<Page />, document.getElementById("page"));
