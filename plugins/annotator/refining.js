// What the correcting page makes of a click: a thing with its outline and name.
import { outlined } from './clicks.js';
import { blank } from './offers.js';
import { edit, find, state } from './state.js';

export const freeMask = () => Math.max(state.free - 1, ...state.project.objects.map((item) => item.mask)) + 1;

export const page = {
  about: () => ({}),
  outlines: (item) => state.solved.regions[item.id]?.outlines ?? [],
  async put(outlines, named, now, renames) {
    const item = now?.item, label = item?.label && !(renames && item.label === now.was?.label) ? item.label : named.label || null;
    const mask = item?.mask ?? freeMask(), id = item?.id ?? `drawn_${mask}`;
    state.proposals[mask] = named.names;
    edit((project) => {
      if (!item) project.objects.push(blank(id, mask));
      Object.assign(find(id), outlined(outlines), { around: null, label }, label === named.label ? { articulated: named.opens || null } : {});
    });
    return id;
  },
};
