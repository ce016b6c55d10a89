// What the graphics card draws of a rig is where the service has it, by each way of skinning.  The vertex shader that
// three.js draws the model with is linked anew with its places captured, and run over the vertices that were bound to it.
import { expect, type Page } from "@playwright/test";
import type { Unit } from "../src/api/types";
import { mmFrom } from "../src/ui/units";
import { hook, look, untilFitted, untilStill } from "./page";

const TOLERANCE = 0.1; // mm

interface Ply {
  readonly vertices: number;
  readonly triangles: number;
  readonly at: (vertex: number) => number[];
}

/** x, y, z of the vertices of the service's binary PLY. */
function readPly(file: Buffer): Ply {
  const end = file.indexOf("end_header\n") + "end_header\n".length;
  const header = file.toString("latin1", 0, end);
  const count = (name: string): number => Number(new RegExp(`element ${name} (\\d+)`).exec(header)![1]);
  const isDouble = header.includes("property double x");
  const [size, read] = isDouble ? ([8, file.readDoubleLE.bind(file)] as const) : ([4, file.readFloatLE.bind(file)] as const);
  const stride = size * header.slice(header.indexOf("element vertex"), header.indexOf("element face")).match(/property/g)!.length;
  return { vertices: count("vertex"), triangles: count("face"), at: (vertex) => [0, 1, 2].map((k) => read(end + stride * vertex + size * k)) };
}

declare global {
  interface Window {
    /** of a model with so many triangles and vertices, as it is drawn next: its places in the scan's frame, m */
    capture: { triangles: number; vertices: number; places: number[][] | null } | null;
  }
}

/** In the page, before it starts: watches what is drawn. */
function watchDrawing(): void {
  window.capture = null;
  const { prototype } = WebGL2RenderingContext;
  const { value: draw } = Object.getOwnPropertyDescriptor(prototype, "drawElements") as { value: (this: WebGL2RenderingContext, ...drawn: number[]) => void };
  prototype.drawElements = function (mode, count, type, offset) {
    draw.call(this, mode, count, type, offset);
    const { capture } = window;
    if (capture && !capture.places && offset === 0 && count === 3 * capture.triangles) capture.places = placesIn(this, capture.vertices);
  };

  /** Null where what is bound is not drawn with light. */
  function placesIn(gl: WebGL2RenderingContext, vertices: number): number[][] | null {
    const drawn = gl.getParameter(gl.CURRENT_PROGRAM) as WebGLProgram;
    const source = gl.getAttachedShaders(drawn)!.map((shader) => gl.getShaderSource(shader)!).find((text) => text.includes("gl_Position"))!;
    if (!source.includes("vViewPosition")) return null;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, source], [gl.FRAGMENT_SHADER, "#version 300 es\nvoid main() {}"]] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    for (let i = 0; i < (gl.getProgramParameter(drawn, gl.ACTIVE_ATTRIBUTES) as number); i += 1) {
      const { name } = gl.getActiveAttrib(drawn, i)!;
      const place = gl.getAttribLocation(drawn, name);
      if (place >= 0) gl.bindAttribLocation(program, place, name);
    }
    gl.transformFeedbackVaryings(program, ["vViewPosition"], gl.SEPARATE_ATTRIBS);
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program)!);
    gl.useProgram(program);
    const setters: Record<number, (at: WebGLUniformLocation, value: never) => void> = {
      [gl.FLOAT]: (at, value) => gl.uniform1f(at, value),
      [gl.FLOAT_VEC2]: (at, value) => gl.uniform2fv(at, value),
      [gl.FLOAT_VEC3]: (at, value) => gl.uniform3fv(at, value),
      [gl.FLOAT_VEC4]: (at, value) => gl.uniform4fv(at, value),
      [gl.FLOAT_MAT3]: (at, value) => gl.uniformMatrix3fv(at, false, value),
      [gl.FLOAT_MAT4]: (at, value) => gl.uniformMatrix4fv(at, false, value),
      [gl.INT_VEC2]: (at, value) => gl.uniform2iv(at, value),
    };
    for (let i = 0; i < (gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) as number); i += 1) {
      const { name, size, type } = gl.getActiveUniform(program, i)!;
      for (let k = 0; k < size; k += 1) {
        const one = size > 1 ? name.replace("[0]", `[${k}]`) : name;
        const value = gl.getUniform(drawn, gl.getUniformLocation(drawn, one)!) as never;
        (setters[type] ?? gl.uniform1i.bind(gl))(gl.getUniformLocation(program, one)!, value); // what else there is are textures and switches
      }
    }
    const view = gl.getUniform(program, gl.getUniformLocation(program, "modelViewMatrix")!) as Float32Array;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.TRANSFORM_FEEDBACK_BUFFER, buffer);
    gl.bufferData(gl.TRANSFORM_FEEDBACK_BUFFER, 12 * vertices, gl.STATIC_READ);
    gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    gl.enable(gl.RASTERIZER_DISCARD);
    gl.beginTransformFeedback(gl.POINTS);
    gl.drawArrays(gl.POINTS, 0, vertices);
    gl.endTransformFeedback();
    gl.disable(gl.RASTERIZER_DISCARD);
    const read = new Float32Array(3 * vertices);
    gl.getBufferSubData(gl.TRANSFORM_FEEDBACK_BUFFER, 0, read);
    gl.bindBufferBase(gl.TRANSFORM_FEEDBACK_BUFFER, 0, null);
    gl.useProgram(drawn);
    const back = new DOMMatrix([...view]).inverse();
    return Array.from({ length: vertices }, (_, i) => {
      const { x, y, z } = back.transformPoint({ x: -read[3 * i]!, y: -read[3 * i + 1]!, z: -read[3 * i + 2]! });
      return [x, y, z];
    });
  }
}

export interface Made {
  readonly id: string;
  readonly unit: Unit;
}

/** Fits, opens the page, and compares what it draws of the model with fitted.ply. */
export async function compare(page: Page, base: string, scan: Made, landmarks?: object, preset?: string): Promise<void> {
  const answer = await page.request.post(`${base}/api/fits`, { data: { scan: scan.id, refine: false, preset, ...(landmarks ? { landmarks } : {}) } });
  const fit = (await answer.json()) as Made;
  await page.goto("about:blank"); // what comes is another document
  await page.addInitScript(watchDrawing);
  await page.goto(`${base}/#scan=${scan.id}&fit=${fit.id}`);
  await hook.ready(page);
  await untilFitted(page);
  await look(page, "Model");
  await untilStill(page);
  const { vertices, triangles, at } = readPly(await (await page.request.get(`${base}/api/fits/${fit.id}/fitted.ply`)).body());
  const places = await page.evaluate((size) => {
    window.capture = { ...size, places: null };
    window.__breastrig!.picture(); // draws
    return window.capture.places;
  }, { vertices, triangles });
  const gaps = places!.map((place, vertex) => Math.hypot(...at(vertex).map((value, k) => mmFrom(value, scan.unit) - 1000 * place[k]!)));
  expect(gaps).toHaveLength(vertices);
  expect(Math.max(...gaps), "mm").toBeLessThan(TOLERANCE);
}
