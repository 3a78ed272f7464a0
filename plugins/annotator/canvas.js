// The picture on the page, and how to look at it. Pixel centers are at integers, as in every file.
import { changed, state } from './state.js';

const svg = document.getElementById('view');
const SVG = 'http://www.w3.org/2000/svg';
let box = null;

export function element(name, attributes, children = []) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
export const line = ([a, b], kind) => element('line', { x1: a[0], y1: a[1], x2: b[0], y2: b[1], class: kind });
export const area = (points, kind) => element('polygon', { points: points.map((p) => p.join()).join(' '), class: kind });
export const frame = ([[x0, y0], [x1, y1]]) => area([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], 'outline quiet');
// Clicks that add or take away.
export const dots = (clicks) => clicks.map(([x, y, adds]) => element('circle', { cx: x, cy: y, r: 4 * unit(), class: `click quiet${adds ? '' : ' off'}` }));
// A name in the picture, before its right border, which would cut it off.
export function name(text, [x, y]) {
  const size = 13 * unit(), room = state.project.width - 0.6 * size * text.length;
  return element('text', { x: Math.max(0, Math.min(x, room)), y, 'font-size': size }, [text]);
}
// Where the name of a thing stands: at the upper left point of its largest outline, whatever stray pixels it has.
export function corner(outlines) {
  const points = outlines.reduce((one, other) => (spread(other) > spread(one) ? other : one));
  const [x, y] = points.reduce((one, other) => (other[0] + other[1] < one[0] + one[1] ? other : one));
  return [x, y + 13 * unit()];
}
const reach = (sides) => Math.max(...sides) - Math.min(...sides);
const spread = (points) => reach(points.map(([x]) => x)) * reach(points.map(([, y]) => y));
export const unit = () => box.width / Math.max(1, Math.min(svg.clientWidth, (svg.clientHeight * box.width) / box.height));

export function begin() {
  const { width, height } = state.project;
  svg.append(element('image', { href: 'picture.jpg', x: -0.5, y: -0.5, width, height }), element('g', { id: 'over' }));
  fit();
}

function look() { svg.setAttribute('viewBox', `${box.x} ${box.y} ${box.width} ${box.height}`); }
export function fit() {
  const { width, height } = state.project;
  box = { x: -0.5 - 0.04 * width, y: -0.5 - 0.04 * height, width: 1.08 * width, height: 1.08 * height };
  look();
}
export function zoom(factor, at = [box.x + box.width / 2, box.y + box.height / 2]) {
  const { width } = state.project;
  const size = Math.min(20 * width, Math.max(width / 40, box.width * factor)) / box.width;
  box = { x: at[0] - (at[0] - box.x) * size, y: at[1] - (at[1] - box.y) * size, width: box.width * size, height: box.height * size };
  look();
  changed();
}
export function move(dx, dy) { box.x += dx; box.y += dy; look(); }
export function pixel(event) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return [Math.round(10 * point.x) / 10, Math.round(10 * point.y) / 10];
}
