/** Draws a tileset by CesiumJS on a flat magenta background. Points are in the frame of its boxes. */
const { Cesium } = globalThis;
Cesium.Ion.defaultAccessToken = undefined;

const widget = new Cesium.CesiumWidget('view', {
  baseLayer: false, globe: false, skyBox: false, skyAtmosphere: false, scene3DOnly: true,
  contextOptions: { webgl: { preserveDrawingBuffer: true, antialias: false } },
});
const { scene } = widget;
scene.backgroundColor = Cesium.Color.MAGENTA;
scene.fog.enabled = false;
scene.highDynamicRange = false;
scene.msaaSamples = 1;
scene.postProcessStages.fxaa.enabled = false;
for (const body of [scene.sun, scene.moon]) if (body) body.show = false;

/** A local tileset stands anywhere on the globe: its axes become east, north and up there. One on the Earth brings its frame. */
let frame = Cesium.Transforms.eastNorthUpToFixedFrame(Cesium.Cartesian3.fromDegrees(-112.187, 37.593, 2400));
const place = (point) => Cesium.Matrix4.multiplyByPoint(frame, new Cesium.Cartesian3(...point), new Cesium.Cartesian3());
const turn = (vector) => Cesium.Matrix4.multiplyByPointAsVector(frame, vector, new Cesium.Cartesian3());

let tileset;
let shown = new Set();   // files of the tiles in the frame that is being drawn
const errors = [];

const nextFrame = () => new Promise((done) => {
  const forget = scene.postRender.addEventListener(() => {
    forget();
    done();
  });
});

/** Longitude, latitude [degrees] and height [m] above the ellipsoid of the middle of what is loaded. */
globalThis.loadTileset = async (url, error) => {
  const { root } = await (await fetch(url)).json();
  if (root.transform) frame = Cesium.Matrix4.fromArray(root.transform);
  tileset = await Cesium.Cesium3DTileset.fromUrl(url, {
    maximumScreenSpaceError: error, dynamicScreenSpaceError: false, foveatedScreenSpaceError: false,
    modelMatrix: root.transform ? Cesium.Matrix4.IDENTITY : frame,
  });
  tileset.tileFailed.addEventListener(({ url: file, message }) => errors.push(`${file}: ${message}`));
  tileset.tileVisible.addEventListener(({ content }) => {
    for (const file of content.innerContents ?? [content]) shown.add(file.url);
  });
  scene.renderError.addEventListener((where, reason) => errors.push(String(reason)));
  scene.primitives.add(tileset);
  const { longitude, latitude, height } = Cesium.Cartographic.fromCartesian(tileset.boundingSphere.center);
  return [Cesium.Math.toDegrees(longitude), Cesium.Math.toDegrees(latitude), height];
};

/** Draws until everything needed is there for some frames; the files on screen and what went wrong. */
globalThis.drawTileset = async ({ position, target, fov, near }, frames = 15) => {
  const { camera } = scene;
  const along = Cesium.Cartesian3.normalize(
    Cesium.Cartesian3.subtract(new Cesium.Cartesian3(...target), new Cesium.Cartesian3(...position), new Cesium.Cartesian3()),
    new Cesium.Cartesian3());
  const side = Cesium.Cartesian3.normalize(Cesium.Cartesian3.cross(along, Cesium.Cartesian3.UNIT_Z, new Cesium.Cartesian3()), new Cesium.Cartesian3());
  const up = Cesium.Cartesian3.cross(side, along, new Cesium.Cartesian3());
  const aspect = innerWidth / innerHeight;   // its angle of view is along the longer side
  camera.frustum.fov = 2 * Math.atan(Math.tan((fov * Math.PI) / 360) * Math.max(1, aspect));
  camera.frustum.near = near;
  // setView goes by heading and pitch, and turns a view that is nearly straight up.
  Object.entries({ position: place(position), direction: turn(along), up: turn(up), right: turn(side) })
    .forEach(([name, vector]) => Cesium.Cartesian3.clone(vector, camera[name]));
  for (let still = 0; still < frames && errors.length === 0;) {
    shown = new Set();
    await nextFrame();
    still = tileset.tilesLoaded ? still + 1 : 0;
  }
  return { shown: [...shown], errors };
};
