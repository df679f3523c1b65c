// @ts-check
/**
 * Numbers as texts, and rotations as angles.
 * @module
 */

/**
 * A number with a fixed count of digits, without a minus sign before zero.
 * @param {number} value
 * @param {number} digits
 */
export function fixed(value, digits) {
  if (!Number.isFinite(value)) return '–';
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace('-', '') : text;
}

/**
 * A number as short as it can be at a precision of four digits.
 * @param {number} value
 */
export function short(value) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? '–' : value > 0 ? '∞' : '-∞';
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

/** @param {number} angle [rad] */
export const degrees = (angle) => (angle * 180) / Math.PI;

/** @param {number} angle [deg] */
export const radians = (angle) => (angle * Math.PI) / 180;

/**
 * Roll, pitch and yaw [rad] of a quaternion.
 * @param {ArrayLike<number>} q w, x, y, z
 * @returns {[number, number, number]}
 */
export function anglesOf(q) {
  const [w, x, y, z] = [q[0] ?? 1, q[1] ?? 0, q[2] ?? 0, q[3] ?? 0];
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.min(Math.max(2 * (w * y - z * x), -1), 1)),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}

/**
 * The quaternion w, x, y, z of roll, pitch and yaw [rad].
 * @param {number} roll
 * @param {number} pitch
 * @param {number} yaw
 * @returns {[number, number, number, number]}
 */
export function quaternionOf(roll, pitch, yaw) {
  const [a, b, c] = [Math.cos(roll / 2), Math.cos(pitch / 2), Math.cos(yaw / 2)];
  const [p, q, r] = [Math.sin(roll / 2), Math.sin(pitch / 2), Math.sin(yaw / 2)];
  return [a * b * c + p * q * r, p * b * c - a * q * r, a * q * c + p * b * r, a * b * r - p * q * c];
}

/**
 * A time span [s] such as 1:02:03.45.
 * @param {number} seconds
 */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return '–';
  const sign = seconds < 0 ? '-' : '';
  const whole = Math.abs(seconds);
  if (whole < 60) return `${sign}${whole.toFixed(2)} s`;
  const minutes = Math.floor(whole / 60);
  const rest = (whole - 60 * minutes).toFixed(2).padStart(5, '0');
  return minutes < 60
    ? `${sign}${minutes}:${rest}`
    : `${sign}${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, '0')}:${rest}`;
}

/** A unit with its exponents raised: m/s². @param {string} unit */
export const shownUnit = (unit) => unit.replaceAll('^2', '²').replaceAll('^3', '³');

/** @param {string} text */
export const capitalized = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** A colour as controls have it: #rrggbb. @param {number[]} parts red, green and blue, 0 to 1 */
export const hexOf = (parts) =>
  `#${parts.slice(0, 3).map((part) => Math.round(255 * Math.min(Math.max(part, 0), 1)).toString(16).padStart(2, '0')).join('')}`;

/** Red, green and blue, 0 to 1. @param {string} hex #rrggbb */
export const partsOf = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
