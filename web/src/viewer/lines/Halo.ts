// How sure lines and points are, as one band on the skin around all of them, at its true width: a soft fill with a thin edge;
// hatched where no width is known.  One mesh, drawn once.
import { BufferAttribute, BufferGeometry, DataTexture, FloatType, Mesh, RedFormat, RGBAFormat, ShaderMaterial, type Vector3 } from "three";
import type { Viewer } from "../Viewer";
import { type Banded, patchOf, type Pieces, piecesOf, radiusAt } from "./haloPatch";

const TOWARDS_EYE = 0.006; // metres: over the noise of scan and fit, under the lines
const WIDE = 1024; // texels in a row
const FILL = 0.24; // opacity
const EDGE = 0.62;
const EDGE_PIXELS = 1.1;
const HATCH_PIXELS = 7;

const NOTHING = piecesOf([]);

export class Halo {
  readonly mesh: Mesh<BufferGeometry, ShaderMaterial>;
  private pieces: Pieces = NOTHING;

  /** `name`: whose it is; `order`: see Object3D.renderOrder. */
  constructor(private readonly viewer: Viewer, name: string, order: number) {
    this.mesh = new Mesh(new BufferGeometry(), bandMaterial());
    this.mesh.name = name;
    this.mesh.renderOrder = order; // after the translucent model, before the lines
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
    this.mesh.raycast = () => undefined;
    this.mesh.onBeforeRender = (renderer) => (this.mesh.material.uniforms.ratio!.value = renderer.getPixelRatio());
    viewer.body.add(this.mesh);
    viewer.beforeFrame.add(() => (this.mesh.material.polygonOffsetUnits = -TOWARDS_EYE * viewer.depthUnits));
  }

  /** `skin`: on which they lie; it has its BVH. */
  set(lines: readonly Banded[], skin: BufferGeometry | null): void {
    const { geometry, material } = this.mesh;
    this.pieces = skin?.boundsTree && lines.length > 0 ? piecesOf(lines) : NOTHING;
    const { pieces } = this;
    this.mesh.visible = pieces.count > 0;
    this.mesh.userData.radii = pieces.count > 0 ? lines.flatMap(({ radii }) => [...radii].filter((radius) => !Number.isNaN(radius))) : []; // for tests
    geometry.dispose();
    for (const name of ["pieces", "entries"] as const) (material.uniforms[name]!.value as DataTexture | null)?.dispose();
    this.viewer.invalidate();
    if (!this.mesh.visible) return;
    const patch = patchOf(skin!, pieces);
    this.mesh.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(patch.position, 3)).setAttribute("range", new BufferAttribute(patch.range, 2));
    material.uniforms.pieces!.value = textureOf(pieces.texels, 4);
    material.uniforms.entries!.value = textureOf(patch.entries, 1);
  }

  /** The radius of the line in whose band a place on the skin lies, metres; null outside. */
  radiusAt(place: Vector3, normal: Vector3): number | null {
    return radiusAt(this.pieces, place, normal);
  }
}

/** `values` row by row; it ends with texels that nobody reads. */
function textureOf(values: Float32Array, size: 1 | 4): DataTexture {
  const rows = Math.max(1, Math.ceil(values.length / size / WIDE));
  const texels = new Float32Array(size * WIDE * rows);
  texels.set(values);
  const made = new DataTexture(texels, WIDE, rows, size === 1 ? RedFormat : RGBAFormat, FloatType);
  made.needsUpdate = true;
  return made;
}

function bandMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: { pieces: { value: null }, entries: { value: null }, ratio: { value: 1 } },
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    vertexShader: `
      attribute vec2 range;
      varying vec3 vAt;
      flat varying ivec2 vRange;
      void main() {
        vAt = position;
        vRange = ivec2(range);
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `
      uniform highp sampler2D pieces;
      uniform highp sampler2D entries;
      uniform float ratio;
      varying vec3 vAt;
      flat varying ivec2 vRange;
      ivec2 texel(int at) { return ivec2(at % ${WIDE}, at / ${WIDE}); }
      void main() {
        float depth = -1.0;
        vec4 look = vec4(0.0);
        for (int k = 0; k < vRange.y; k += 1) {
          int piece = 3 * int(texelFetch(entries, texel(vRange.x + k), 0).r);
          vec4 from = texelFetch(pieces, texel(piece), 0);
          vec4 to = texelFetch(pieces, texel(piece + 1), 0);
          vec3 way = to.xyz - from.xyz;
          float along = clamp(dot(vAt - from.xyz, way) / max(dot(way, way), 1e-12), 0.0, 1.0);
          float inside = mix(from.w, to.w, along) - distance(vAt, from.xyz + along * way);
          if (inside <= depth) continue;
          depth = inside;
          look = texelFetch(pieces, texel(piece + 2), 0);
        }
        float pixel = max(fwidth(depth), 1e-7);
        float shown = clamp(depth / pixel + 0.5, 0.0, 1.0);
        float edge = 1.0 - smoothstep(${EDGE_PIXELS.toFixed(1)}, ${(EDGE_PIXELS + 1).toFixed(1)}, depth / (pixel * ratio));
        vec2 hatch = gl_FragCoord.xy / (ratio * ${HATCH_PIXELS.toFixed(1)});
        float stripe = 1.0 - smoothstep(0.16, 0.26, abs(fract(hatch.x + hatch.y) - 0.5));
        float strength = look.a > 0.5 ? ${EDGE.toFixed(2)} * stripe : mix(${FILL.toFixed(2)}, ${EDGE.toFixed(2)}, edge);
        gl_FragColor = vec4(look.rgb, strength * shown);
        if (gl_FragColor.a < 0.004) discard;
        #include <colorspace_fragment>
      }`,
  });
}
