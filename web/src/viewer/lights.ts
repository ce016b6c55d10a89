// Light travels with the eye: key from the upper left, a soft fill, a gentle rim.  The back of the body is then as
// well lit as its front, and relief reads the same from every side.
import { type Camera, DirectionalLight, HemisphereLight, type Object3D } from "three";

function lamp(camera: Camera, intensity: number, x: number, y: number, z: number): void {
  const light = new DirectionalLight(0xffffff, intensity);
  light.position.set(x, y, z);
  light.target.position.set(0, 0, -1);
  camera.add(light, light.target);
}

export function addLights(scene: Object3D, camera: Camera): void {
  scene.add(new HemisphereLight(0xffffff, 0x8d8780, 1.15), camera);
  lamp(camera, 2.3, -1.3, 1.3, 0.35);
  lamp(camera, 0.35, 1.2, 0, 0.4);
  lamp(camera, 0.45, 0.6, 0.9, -2.2);
}
