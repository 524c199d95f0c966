// The name that the server gives a file, in its Content-Disposition field.
export function nameIn(response, fallback) {
  const found = /filename="([^"]+)"/.exec(response.headers.get("Content-Disposition") || "");
  return found ? found[1] : fallback;
}
