// Renderer, camera, sky and light. The world is in metres, x east, y north, z up.
import {
  BackSide, Color, DirectionalLight, Fog, HemisphereLight, Mesh, LinearToneMapping, NoToneMapping,
  PerspectiveCamera, Scene, ShaderMaterial, SphereGeometry, SRGBColorSpace, Vector2, Vector3,
  WebGLRenderer,
} from 'three';

const SUN_DIRECTION = new Vector3(-0.78, 0.12, 0.62).normalize();
const HORIZON = new Color('#dfe8ec');

const SKY_VERTEX = `
  varying vec3 direction;
  void main() {
    direction = position;
    gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
    gl_Position.z = gl_Position.w;
  }`;
const SKY_FRAGMENT = `
  uniform vec3 horizon, sun;
  varying vec3 direction;
  void main() {
    vec3 d = normalize(direction);
    vec3 zenith = vec3(0.13, 0.30, 0.55), below = vec3(0.44, 0.50, 0.55);
    vec3 colour = mix(horizon, d.z > 0.0 ? zenith : below, pow(abs(d.z), d.z > 0.0 ? 0.6 : 0.45));
    float glow = max(dot(d, sun), 0.0);
    colour += vec3(1.0, 0.86, 0.62) * (0.12 * pow(glow, 8.0) + 0.9 * pow(glow, 900.0));
    gl_FragColor = vec4(colour, 1.0);
    #include <colorspace_fragment>
  }`;

function makeSky() {
  const material = new ShaderMaterial({
    vertexShader: SKY_VERTEX,
    fragmentShader: SKY_FRAGMENT,
    uniforms: { horizon: { value: HORIZON }, sun: { value: SUN_DIRECTION } },
    side: BackSide,
    depthWrite: false,
    depthTest: false,
    toneMapped: false,
    fog: false,
  });
  const sky = new Mesh(new SphereGeometry(1, 32, 24), material);
  sky.frustumCulled = false;
  sky.renderOrder = -1;
  return sky;
}

export class Stage {
  // A flat background is for measuring: every pixel is either it or the terrain.
  constructor(canvas, flatBackground) {
    this.flat = Boolean(flatBackground);
    this.renderer = new WebGLRenderer({
      canvas, antialias: !this.flat, preserveDrawingBuffer: this.flat, stencil: true,
    });
    this.renderer.outputColorSpace = SRGBColorSpace;
    this.renderer.toneMapping = this.flat ? NoToneMapping : LinearToneMapping;
    this.renderer.toneMappingExposure = 0.96;
    this.renderer.setPixelRatio(this.flat ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.localClippingEnabled = true;
    this.camera = new PerspectiveCamera(50, 1, 0.5, 5000);
    this.camera.up.set(0, 0, 1);
    this.scene = new Scene();
    if (this.flat) this.scene.background = new Color(flatBackground);
    else this.scene.add(this.sky = makeSky());
    this.#light();
    this.panes = [() => {}];
    this.needsRender = true;
  }

  // Draws once per pane, after calling its function, which says what is visible there.
  setPanes(shows) {
    this.panes = shows;
    this.width = undefined;
  }
  // A pane in pixels of the page; two stand side by side, or one above the other where there is more height.
  pane(index) {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    const count = this.panes.length;
    if (width >= height) return { left: (index * width) / count, top: 0, width: width / count, height };
    return { left: 0, top: (index * height) / count, width, height: height / count };
  }
  // The pane at a point of the page, and where in it as the camera counts: -1 to 1.
  locate(clientX, clientY) {
    const index = this.panes.findIndex((_, i) => {
      const { left, top, width, height } = this.pane(i);
      return clientX >= left && clientX < left + width && clientY >= top && clientY < top + height;
    });
    const { left, top, width, height } = this.pane(Math.max(0, index));
    const at = new Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2);
    return { index: Math.max(0, index), at };
  }

  #light() {
    this.sun = new DirectionalLight('#fff4e6', 2.8);
    this.sun.shadow.mapSize.set(2048, 2048);
    this.scene.add(this.sun, this.sun.target);
    this.daylight = new HemisphereLight('#d6e6f5', '#a0968a', 1.25);
    this.daylight.position.set(0, 0, 1);
    this.scene.add(this.daylight);
  }

  set shadows(on) {
    this.renderer.shadowMap.enabled = on && !this.flat;
    this.sun.castShadow = on && !this.flat;
    this.shadowsChanged();
    this.scene.traverse((object) => {
      if (object.isMesh) object.material.needsUpdate = true;
    });
  }
  set fog(on) {
    this.scene.fog = on ? new Fog(HORIZON, 1, 2) : null;
    this.needsRender = true;
  }
  shadowsChanged() {
    this.renderer.shadowMap.needsUpdate = true;
    this.needsRender = true;
  }

  // Fits the depth range and the shadow to what there is to see. `near` is the scale of what the
  // camera looks at in metres, `world` a sphere around everything.
  fit(target, near, world) {
    const { camera, sun } = this;
    const away = camera.position.distanceTo(world.center);
    camera.near = Math.max(0.05, Math.min(0.05 * near, 0.002 * world.radius), away - world.radius);
    camera.far = Math.max(camera.near * 2, away + world.radius);
    camera.updateProjectionMatrix();
    if (this.scene.fog) {
      this.scene.fog.near = Math.max(near, 0.2 * world.radius);
      this.scene.fog.far = this.scene.fog.near + 2.5 * world.radius;
    }
    const radius = Math.min(world.radius, 1.5 * near);
    const middle = radius < world.radius ? target : world.center;
    const moved = sun.target.position.distanceTo(middle) > 0.1 * radius;
    const resized = Math.abs(this.shadowRadius - radius) > 0.1 * radius || !this.shadowRadius;
    if (!moved && !resized) return;
    this.shadowRadius = radius;
    sun.target.position.copy(middle);
    sun.position.copy(middle).addScaledVector(SUN_DIRECTION, 2 * world.radius);
    const box = sun.shadow.camera;
    box.left = box.bottom = -radius * 1.1;
    box.right = box.top = radius * 1.1;
    box.near = 0;
    box.far = 4 * world.radius;
    box.updateProjectionMatrix();
    sun.shadow.normalBias = (2.2 * radius * 2) / sun.shadow.mapSize.x;
    sun.shadow.bias = -0.0002;
    this.shadowsChanged();
  }

  // True when the size of the page changed.
  resize() {
    const { clientWidth, clientHeight } = this.renderer.domElement;
    if (this.width === clientWidth && this.height === clientHeight) return false;
    this.width = clientWidth;
    this.height = clientHeight;
    this.renderer.setSize(clientWidth, clientHeight, false);
    const { width, height } = this.pane(0);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.needsRender = true;
    return true;
  }

  render() {
    const { renderer } = this;
    const split = this.panes.length > 1;
    renderer.setScissorTest(split);
    this.panes.forEach((show, i) => {
      const { left, top, width, height } = this.pane(i);
      const bottom = renderer.domElement.clientHeight - top - height;
      renderer.setViewport(left, bottom, width, height);
      renderer.setScissor(left, bottom, width, height);
      show();
      if (split) renderer.shadowMap.needsUpdate = true;
      renderer.render(this.scene, this.camera);
    });
    this.needsRender = false;
  }
}
