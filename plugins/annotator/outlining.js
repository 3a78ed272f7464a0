// What the drawing page makes of a click: an object with its outline, its name, and the box that it would be in.
import { end, clicked, outlined } from './clicks.js';
import { ask, changed, copy, edit, find, freeId, state } from './state.js';

const others = (id) => ({ ...copy(state.project), objects: state.project.objects.filter((item) => item.id !== id) });
// A box stays as proposed until a person has drawn it or said what it is on; likewise a name.
const isAsProposed = (now) => now?.was && ['on', 'points'].every((key) => JSON.stringify(now.item[key]) === JSON.stringify(now.was[key]));
const about = (item) => ({ project: others(item?.id), on: item ? 'auto' : state.next });
const place = (item, outlines, label) => ask('place', { ...about(item), outlines, label });

export const page = {
  about,
  outlines: (item) => [item.outline, ...item.pieces ?? []],
  async put(outlines, named, now, renames) {
    const item = now?.item, label = item?.label && !(renames && item.label === now.was?.label) ? item.label : named.label;
    const box = !item || isAsProposed(now) ? await place(item, outlines, label) : {};
    const id = item?.id ?? freeId('object');
    state.proposals[id] = named.names;
    edit((project) => {
      if (!item) project.objects.push({ id, free: false, round: false, doors: 0, drawers: 0 });
      Object.assign(find(id), outlined(outlines), box, { label }, label === named.label ? { articulated: named.opens } : {});
    });
    state.next = 'auto';
    return id;
  },
};

// What was left out is drawn by a click, under its first name.
export async function take(id) {
  const { left_out: why, ...found } = state.project.left_out.find((one) => one.id === id), label = found.names[0].name;
  try {
    const box = await place(null, page.outlines(found), label);
    if (find(id)) return; // by a click before this one
    edit((project) => {
      project.left_out = project.left_out.filter((one) => one.id !== id);
      project.objects.push({ ...found, free: false, round: false, doors: 0, drawers: 0, label, ...box });
    });
    state.chosen = id;
    state.next = 'auto';
    state.trouble = '';
  } catch (error) { state.trouble = error.message; }
  changed();
}

// Another name has other usual sizes: its box is proposed anew, as part of the same step.
export async function named(item) {
  const now = clicked();
  end();
  if (now?.item === item && isAsProposed(now)) {
    const box = await place(item, page.outlines(item), item.label);
    edit(() => Object.assign(item, box), false);
  }
}
