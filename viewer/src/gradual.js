// A picture of very many triangles: few of them while it changes, and all of them, some in every frame, when it rests.

import { COARSE, MOVING, STILL, SURFACE } from "./layers.js";

/** Milliseconds without a change after which all triangles are drawn. */
const REST = 150;
/** Longest and shortest that a frame should take [ms]: between them the number of triangles stays. */
const [LONGEST, SHORTEST] = [60, 30];
/** Triangles of the first frame: graphics without a card draw so many in a few hundredths of a second. */
const FIRST = 6000;
const LEAST = 2000;

export class GradualPicture {
  constructor(view) {
    this.view = view;
    this.most = FIRST;
    this.steps = null;
    this.timer = 0;
    // What is seen while the picture below is not complete.
    this.cover = Object.assign(document.createElement("canvas"), { className: "cover" });
  }

  /** True from the first of its frames to the last. */
  get isBusy() {
    return this.steps !== null;
  }

  /** Graphics that draw all triangles in a frame need no fewer. */
  get isQuick() {
    return 3 * this.most >= this.view.mesh.geometry.index.count;
  }

  /** Draws few triangles now, and all of them when nothing has changed for a moment. */
  changing() {
    this.stop();
    this.coarse();
    this.timer = setTimeout(() => this.begin(), REST);
  }

  /** Draws few triangles in the picture of this frame. */
  coarse() {
    const { renderer, scene, camera, mesh, coarse, host } = this.view;
    coarse.visible = mesh.visible;
    camera.layers.disable(SURFACE);
    camera.layers.enable(COARSE);
    renderer.render(scene, camera);
    camera.layers.disable(COARSE);
    camera.layers.enable(SURFACE);
    host.dataset.picture = "coarse";
  }

  /** Draws all triangles over the next frames; what was there is seen until then. */
  begin() {
    this.stop();
    const { renderer, host } = this.view;
    if (!this.view.size) return;
    const { domElement: picture } = renderer;
    Object.assign(this.cover, { width: picture.width, height: picture.height });
    this.cover.getContext("2d").drawImage(picture, 0, 0);
    host.append(this.cover);
    host.dataset.picture = "coarse";
    const steps = (this.steps = this.whole());
    let before = null;
    const frame = (now) => {
      if (this.steps !== steps) return;
      if (before !== null && now - before > LONGEST) this.most = Math.max(this.most / 2, LEAST);
      else if (before !== null && now - before < SHORTEST) this.most *= 2;
      before = now;
      if (steps.next().done) this.end();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** Leaves the picture unfinished: another one follows. */
  stop() {
    clearTimeout(this.timer);
    this.steps = null;
    this.cover.remove();
    this.view.still.isFresh = false;
  }

  end() {
    this.steps = null;
    this.view.host.dataset.picture = "whole";
  }

  /** Colours of what stands still, then what moves, where it is then; depths are for the pictures to come. */
  *whole() {
    const { still, scene, renderer } = this.view;
    still.prepare();
    yield* this.still();
    renderer.copyFramebufferToTexture(still.colours);
    this.drawLayer(MOVING, false);
    this.cover.remove();
    yield* this.still(() => still.beginDepths(scene), () => still.endDepths(scene));
    still.coverAll();
    still.isFresh = true;
  }

  /** Draws what stands still, a part of the surface a frame, between two calls that choose where. */
  *still(before = () => undefined, after = () => undefined) {
    const { mesh } = this.view;
    const { index } = mesh.geometry;
    let first = 0;
    while (mesh.visible && first < index.count) {
      const count = 3 * Math.round(this.most);
      before();
      mesh.geometry.setDrawRange(first, count);
      this.drawLayer(SURFACE, first === 0);
      mesh.geometry.setDrawRange(0, Infinity);
      after();
      first += count;
      yield;
    }
    before();
    this.drawLayer(STILL, first === 0);
    after();
    yield;
  }

  drawLayer(layer, isFirst) {
    const { renderer, scene, camera } = this.view;
    camera.layers.set(layer);
    renderer.autoClear = isFirst;
    renderer.render(scene, camera);
    renderer.autoClear = true;
    for (const seen of [STILL, MOVING, SURFACE]) camera.layers.enable(seen);
  }

  dispose() {
    this.stop();
  }
}
