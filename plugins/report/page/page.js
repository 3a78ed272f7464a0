// The page works without this script; with it pictures open large, films stop, and reconstructions slide over the input.
const root = document.documentElement;

// Remembers a choice where the browser lets a local file do so.
const memory = {
  get(key) { try { return localStorage.getItem(key); } catch { return null; } },
  set(key, value) { try { localStorage.setItem(key, value); } catch { /* not remembered */ } },
};

// Light or dark: the system's choice until the button is pressed.
const theme = document.getElementById("theme");
const dark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (root.dataset.theme ?? (dark.matches ? "dark" : "light")) === "dark";
const nameTheme = () => { theme.textContent = isDark() ? "Light" : "Dark"; theme.ariaLabel = `${theme.textContent} colors`; };
if (["light", "dark"].includes(memory.get("theme"))) root.dataset.theme = memory.get("theme");
theme.hidden = false;
theme.addEventListener("click", () => {
  root.dataset.theme = isDark() ? "light" : "dark";
  memory.set("theme", root.dataset.theme);
  nameTheme();
});
dark.addEventListener("change", nameTheme);
nameTheme();

// Films: a button stops them all, by showing their still frames.
const motion = document.getElementById("motion");
const films = [...document.querySelectorAll(".film picture")];
const still = matchMedia("(prefers-reduced-motion: reduce)");
const showFilms = (moving) => {
  for (const film of films) film.querySelector("source").media = moving ? "not all" : "all";
  motion.ariaPressed = String(!moving);
  motion.textContent = moving ? "Stop films" : "Play films";
};
motion.hidden = films.length === 0;
motion.addEventListener("click", () => showFilms(motion.ariaPressed === "true"));
showFilms(!still.matches);

// Comparisons: rank by radio button, beside or over each other, the seam by slider, key, finger or mouse.
for (const compare of document.querySelectorAll(".compare")) {
  const [mode, slider, pair] = [".mode", "input[type=range]", ".pair"].map((name) => compare.querySelector(name));
  const lay = (over) => {
    compare.dataset.mode = over ? "over" : "beside";
    mode.ariaPressed = String(over);
    mode.textContent = over ? "Put beside each other" : "Lay over each other";
  };
  const seam = () => pair.style.setProperty("--seam", `${slider.value}%`);
  mode.addEventListener("click", () => lay(compare.dataset.mode === "beside"));
  slider.addEventListener("input", seam);
  for (const rank of compare.querySelectorAll("input[type=radio]")) {
    rank.addEventListener("change", () => {
      for (const image of compare.querySelectorAll("[data-rank]")) image.hidden = image.dataset.rank !== rank.value;
      compare.querySelector(".rank").textContent = rank.value;
      const turn = compare.querySelector(".turn");
      if (!turn) return;
      turn.dataset.scene = `${compare.id}-${rank.value}`;
      turn.querySelector("span").textContent = rank.value;
    });
  }
  const drag = (event) => {
    if (compare.dataset.mode !== "over" || !event.buttons) return;
    const box = pair.getBoundingClientRect();
    slider.value = Math.round(100 * (event.clientX - box.left) / box.width);
    seam();
  };
  for (const kind of ["pointerdown", "pointermove"]) pair.addEventListener(kind, drag);
  lay(matchMedia("(max-width: 640px)").matches);
  compare.classList.add("ready");
}

// Pictures open large in a dialog; Escape, the button or a click closes it.
const viewer = document.getElementById("viewer");
const large = viewer.querySelector("img");
const caption = viewer.querySelector("p");
for (const button of document.querySelectorAll("button.picture")) {
  button.addEventListener("click", () => {
    const picture = button.querySelector("img");
    large.src = picture.src;
    large.alt = caption.textContent = picture.alt;
    viewer.showModal();
  });
}
viewer.addEventListener("click", () => viewer.close());

// The navigation marks the section in view.
const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.hash.slice(1), link]));
const sections = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    for (const [name, link] of links) {
      if (name === entry.target.id) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    }
  }
}, { rootMargin: "-20% 0px -70% 0px" });
for (const section of document.querySelectorAll("main > section")) sections.observe(section);

// A command that corrects an object is copied when it is shown, where the browser lets a local file do so.
for (const details of document.querySelectorAll("details.correct")) {
  details.addEventListener("toggle", async () => {
    if (!details.open) return;
    try {
      await navigator.clipboard.writeText(details.querySelector("code").textContent);
      details.querySelector("summary").textContent = "copied: run it in the folder of this run";
    } catch { /* it can be selected */ }
  });
}
