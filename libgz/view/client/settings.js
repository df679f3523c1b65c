// @ts-check
/**
 * What a page remembers for its user. Storage may be forbidden or full; then the page forgets.
 * @module
 */

const PREFIX = 'libgz.';

/**
 * A remembered value, or the fallback. A value of another type than the fallback's counts as none.
 * @template T
 * @param {string} name
 * @param {T} fallback
 * @returns {T}
 */
export function recall(name, fallback) {
  try {
    const text = localStorage.getItem(PREFIX + name);
    if (text === null) return fallback;
    const value = JSON.parse(text);
    const same = typeof value === typeof fallback && Array.isArray(value) === Array.isArray(fallback);
    return same && value !== null ? value : fallback;
  } catch {
    return fallback;
  }
}

/**
 * Remember a value, which must be plain data.
 * @param {string} name
 * @param {unknown} value
 */
export function remember(name, value) {
  try {
    localStorage.setItem(PREFIX + name, JSON.stringify(value));
  } catch {
    // The page works without.
  }
}
