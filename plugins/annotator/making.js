// The run that makes again what depends on the page: started, watched and stopped.
import { ask, changed, state } from './state.js';

const get = (id) => document.getElementById(id);

function show({ running, done, total, line, code }) {
  get('make').disabled = running;
  get('stop').hidden = get('progress').hidden = !running;
  Object.assign(get('progress'), { max: total || 1, value: done });
  get('making').hidden = !running && !line;
  get('making').textContent = running && total ? `${done} of ${total}: ${line}` : line;
  get('making').classList.toggle('trouble', !running && code !== 0);
}

async function watch(made) {
  let run = await ask('making');
  while (run.running) {
    show(run);
    await new Promise((go) => setTimeout(go, 500));
    run = await ask('making');
  }
  show(run);
  if (run.code === 0) made();
}

// `write`: saves all first, and says whether it could; `made`: what follows a run that ended well.
export function bindMaking(write, made) {
  const tell = (error) => { state.trouble = error.message; changed(); };
  get('make').addEventListener('click', async () => {
    if (await write()) ask('make', {}).then(() => watch(made)).catch(tell);
  });
  get('stop').addEventListener('click', () => { get('making').textContent = 'it is stopped …'; ask('stop', {}).catch(tell); });
  ask('making').then(({ running }) => running && watch(made)).catch(tell); // the page was loaded again meanwhile
}
