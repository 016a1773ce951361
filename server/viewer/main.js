// The viewer: puts the parts together and runs the frames.
import { Box3, Sphere, Vector3 } from 'three';

import { Compare } from './compare.js';
import { Job, listJobs } from './job.js';
import { Manifest } from './manifest.js';
import { Navigation } from './navigation.js';
import { Panel } from './panel.js';
import { hashOf, readParameters } from './parameters.js';
import { BAKE, explain, isRefused, offerKey } from './session.js';
import { Stage } from './stage.js';
import { Terrain } from './terrain.js';
import { Tools } from './tools.js';

const SAVE_MS = 300;
const parameters = readParameters(location);
const stage = new Stage(document.getElementById('view'), parameters.background);
const terrains = parameters.other ? [new Terrain(stage), new Terrain(stage)] : [new Terrain(stage)];
const [terrain] = terrains;
const navigation = new Navigation(stage, terrains);
const manifests = new Map(); // what bake.json says, by terrain
const tools = new Tools(stage, terrains, manifests, { changed: save, address });
const compare = parameters.other ? new Compare(stage, terrains, manifests, lookAt) : null;
const world = new Sphere(new Vector3(), 1000);
let colours = 'natural';

const setLook = (look) => terrains.forEach((each) => each.setLook(look));
let saveSoon = 0;
// What is chosen stands in the address, too.
const saving = (actions) => Object.fromEntries(Object.entries(actions).map(([name, act]) => [name, (value) => {
  act(value);
  save();
}]));
const panel = new Panel(saving({
  navigation: (mode) => { navigation.mode = mode; },
  colours: (mode) => { colours = mode; setLook({ colours }); },
  wireframe: (on) => setLook({ wireframe: on }),
  skirts: (on) => setLook({ skirts: on }),
  bounds: (on) => terrains.forEach((each) => { each.showBounds = on; }),
  shadows: (on) => { stage.shadows = on; },
  fog: (on) => { stage.fog = on; },
  error: (pixels) => terrains.forEach((each) => each.setErrorTarget(pixels)),
  home: () => showWhole(),
}));

function lookAt(box) {
  navigation.lookAtWhole(box, stage.camera.aspect);
}
function showWhole() {
  if (terrain.box) lookAt(terrain.box);
}

// The camera is set as soon as the world's size is known, so that only needed tiles are fetched, and
// again when the world of a running job grows, unless someone has chosen a view.
const seen = new Box3();
function place() {
  const box = terrain.box;
  if (!box || box.equals(seen)) return;
  const first = seen.isEmpty();
  seen.copy(box);
  box.getBoundingSphere(world);
  const { camera, target } = parameters;
  if (first && camera) navigation.lookFrom(camera, target ?? world.center);
  else if (!camera && (first || !navigation.touched)) showWhole();
  if (!first) return;
  if (parameters.navigation) panel.choose('navigation', parameters.navigation);
  tools.restore(parameters.tools);
}

// A link to what is on screen. The page's own address is kept so, without steps in the history.
function address() {
  const hash = hashOf({
    camera: stage.camera.position, target: navigation.target, navigation: navigation.mode, colours, error: panel.error,
    switches: panel.switches, tools: tools.state,
  });
  return new URL(hash, location).href;
}
function save() {
  clearTimeout(saveSoon);
  saveSoon = setTimeout(() => {
    if (seen.isEmpty()) return;
    history.replaceState(null, '', address());
    tools.share.update(address());
  }, SAVE_MS);
}
// A link opened in the page that it leads to.
addEventListener('hashchange', () => {
  const { camera, target, navigation: mode, colours: colouring, error, switches, tools: said } = readParameters(location);
  if (error) panel.error = error;
  panel.switches = switches;
  panel.choose('navigation', mode ?? 'orbit');
  panel.choose('colours', colouring ?? 'natural');
  if (camera) navigation.lookFrom(camera, target ?? world.center);
  tools.restore(said);
});

// Frames are drawn when something has changed. `idle` counts those since nothing did.
const state = { idle: 0, errors: [], terrain, stage, navigation, tools, compare };
let last = performance.now();
let drawn = 0;
function frame(now) {
  stage.resize();
  place();
  const moved = !seen.isEmpty() && navigation.update((now - last) / 1000);
  last = now;
  stage.camera.updateMatrixWorld();
  if (moved) {
    stage.needsRender = true;
    save();
  }
  for (const each of terrains) each.update();
  tools.update();
  if (!seen.isEmpty()) stage.fit(navigation.target, navigation.scale, world);
  state.idle = moved || stage.needsRender || terrains.some(({ busy }) => busy) ? 0 : state.idle + 1;
  if (stage.needsRender) {
    stage.render();
    ++drawn;
  }
  requestAnimationFrame(frame);
}

setInterval(() => {
  panel.showStatistics(terrain.statistics(), drawn === 0 ? 'idle' : `${drawn * 2}/s`);
  drawn = 0;
}, 500);

function open() {
  for (const each of terrains) {
    each.addEventListener('error', ({ message }) => {
      state.errors.push(message);
      panel.error_message = message;
    });
    each.addEventListener('recovered', () => { panel.error_message = ''; });
  }
  if (parameters.error) panel.error = parameters.error;
  if (parameters.colours) panel.choose('colours', parameters.colours);
  stage.shadows = !parameters.background;
  panel.switches = parameters.switches;
  if (parameters.other) panel.fold(false);
  if (parameters.noUi) document.body.classList.add('bare');
  if (parameters.job) [parameters.job, parameters.other].forEach((id, i) => id && followJob(id, i));
  else if (parameters.tileset) [parameters.tileset, parameters.other].forEach((path, i) => path && showTileset(path, i));
  else showList();
}

async function showList() {
  panel.showNoControls();
  panel.offerKey();
  panel.error_message = '';
  try {
    panel.showJobs(await listJobs());
  } catch (error) {
    const more = isRefused(error) ? ' Enter one by Key.' : ' Load the page again to retry.';
    panel.error_message = explain(error) + more;
  }
}

function showTileset(path, index) {
  compare?.name(index, path);
  openTileset(path, index);
}
function openTileset(path, index) {
  const url = new URL(path, location).href;
  manifests.set(terrains[index], new Manifest(url));
  terrains[index].open(url);
}

function followJob(id, index) {
  const job = new Job(id);
  const fail = (text) => {
    panel.error_message = text;
    if (index === 0) panel.showNoControls();
  };
  let known = null;
  const show = (info) => {
    known = info;
    if (index === 0) panel.showJob(info);
    compare?.name(index, info.title || id);
  };
  job.addEventListener('status', ({ info }) => {
    show(info);
    if (info.processID !== BAKE) fail(`This job has no terrain: it is of ${info.processID}.`);
  });
  job.addEventListener('away', () => { if (index === 0) panel.showAway(); });
  job.addEventListener('back', () => { if (known) show(known); });
  job.addEventListener('missing', () => fail(`There is no job ${id}.`));
  job.addEventListener('error', ({ error }) => fail(explain(error)));
  job.addEventListener('tileset', () => openTileset(job.tileset, index));
  job.follow();
}

globalThis.hoodoo = state; // for tests, and for the curious
offerKey(showList);
open();
requestAnimationFrame(frame);
