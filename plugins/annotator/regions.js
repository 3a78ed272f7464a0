// What lies over the picture on the correcting page: regions of things, what is left out, the chosen thing's box.
import { area, corner, dots, element, frame, name, unit } from './canvas.js';
import { marks } from './clicks.js';
import { drawOffers } from './offers.js';
import { find, nameOf, state } from './state.js';

const get = (id) => document.getElementById(id);
const svg = get('view');
export const ROOM = ['floor', 'wall'];
export const chosen = () => (state.chosen ? find(state.chosen) : null);
export const boxOf = (item) => item.around ?? state.solved?.regions[item.id]?.box;

export function draw() {
  const over = get('over');
  svg.classList.toggle('selecting', state.tool === 'select');
  if (!over || !state.solved) return;
  const parts = [], names = []; // names lie over all else
  for (const item of [...state.project.objects].sort((one, other) => ROOM.includes(other.label) - ROOM.includes(one.label))) {
    const region = state.solved.regions[item.id];
    if (!region) continue;
    const kind = ['region', ROOM.includes(item.label) ? 'room' : '', state.chosen === item.id ? 'chosen' : ''].join(' ').trim();
    parts.push(element('g', { class: kind, 'data-object': item.id }, region.outlines.map((points) => area(points, 'face'))));
    if (item.label && region.outlines.length) names.push(name(nameOf(item), corner(region.outlines)));
  }
  parts.push(...drawOffers());
  const item = chosen();
  const faces = state.solved.regions[item?.id]?.faces ?? []; // as it stands in the scene of rank 1, or will; its front stronger
  faces.forEach((face, k) => parts.push(area(face, `solid quiet${k === faces.length - 1 ? ' front' : ''}`)));
  const box = item && boxOf(item);
  if (box) {
    const [[x0, y0], [x1, y1]] = box;
    parts.push(frame(box));
    [x0, x1].forEach((x, i) => [y0, y1].forEach((y, j) => parts.push(element('circle', { cx: x, cy: y, r: 6 * unit(), class: 'handle', 'data-handle': `${i}${j}` }))));
  }
  const points = state.draft?.points ?? [];
  if (state.draft?.kind === 'frame') parts.push(frame(points));
  else if (points.length) parts.push(element('polyline', { points: points.map((p) => p.join()).join(' '), class: 'measure quiet' }));
  over.replaceChildren(...parts, ...names, ...dots(marks()));
}
