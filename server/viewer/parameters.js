// What the address of the page says.
//
//   ?job=ID or ?tileset=PATH   what to show; a path on this server
//   ?with=ID or PATH           what to compare it to, side by side: a job to a job, a tileset to a tileset
//   ?err=PIXELS                error on screen to refine to; the same after # wins
//   ?bg=COLOUR                 flat background, no lights' effects on it: for measuring pictures
//   ?noui                      no panel
//   ?cam=x,y,z&at=x,y,z        camera in metres of the scene, z up; the same after # wins, and is
//                              kept up to date there, so that a link shows the same view; so are
//   #nav=fly&colours=MODE      how the camera moves, what is coloured
//   #show=wireframe,-skirts    what is shown that is not at first, with a minus what is not
//   #cut=x,METRES[,-]          the cross-section, its other side with a minus
//   #under=1                   underground
//   #measure=x,y,z;x,y,z       the two points of a measurement
import { Vector3 } from 'three';

function vector(text) {
  const numbers = (text ?? '').split(',').map(Number);
  return numbers.length === 3 && numbers.every(Number.isFinite) ? new Vector3(...numbers) : null;
}

const ERROR = 8; // pixels, at first
const TOOLS = ['cut', 'under', 'measure'];

export function readParameters(location) {
  const query = new URLSearchParams(location.search);
  const hash = new URLSearchParams(location.hash.slice(1));
  const either = (key) => hash.get(key) ?? query.get(key);
  return {
    job: query.get('job'),
    tileset: query.get('tileset'),
    other: query.get('with'),
    error: Number(either('err')) || null,
    background: query.get('bg'),
    noUi: query.has('noui'),
    camera: vector(either('cam')),
    target: vector(either('at')),
    navigation: either('nav'),
    colours: either('colours'),
    switches: either('show'),
    tools: Object.fromEntries(TOOLS.map((key) => [key, either(key)])),
  };
}

// View and choices as they stand behind the #. `switches` is a text or null; `tools` has one for each of TOOLS.
export function hashOf({ camera, target, navigation, colours, error, switches, tools }) {
  const short = (v) => v.toArray().map((x) => Number(x.toFixed(2))).join(',');
  const parts = [`cam=${short(camera)}`, `at=${short(target)}`];
  if (navigation !== 'orbit') parts.push(`nav=${navigation}`);
  if (colours !== 'natural') parts.push(`colours=${colours}`);
  if (error !== ERROR) parts.push(`err=${Number(error.toFixed(2))}`);
  for (const [key, text] of Object.entries({ show: switches, ...tools })) if (text !== null) parts.push(`${key}=${text}`);
  return `#${parts.join('&')}`;
}
