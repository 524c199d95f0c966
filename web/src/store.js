// A value that views follow. No view keeps a copy of what another view shows: both follow the same store.
import { useEffect, useReducer } from "preact/hooks";

// {get, set, update, subscribe}; subscribers are told in the next frame, once however often the value changed.
export function createStore(initial) {
  let value = initial;
  let told = true;
  const listeners = new Set();
  const tell = () => {
    told = true;
    for (const listener of [...listeners]) listener(value);
  };
  return {
    get: () => value,
    set(next) {
      if (next === value) return;
      value = next;
      if (told) queueMicrotask(tell);
      told = false;
    },
    update(change) {
      this.set(change(value));
    },
    subscribe(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
}

// The value of a store, or what `select` makes of it; the component is drawn again when that changes.
export function useStore(store, select = (value) => value) {
  const [, redraw] = useReducer((count) => count + 1, 0);
  const selected = select(store.get());
  useEffect(() => {
    let shown = selected;
    const follow = (value) => {
      const next = select(value);
      if (next === shown) return;
      shown = next;
      redraw();
    };
    follow(store.get());
    return store.subscribe(follow);
  });
  return selected;
}
