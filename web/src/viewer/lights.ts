// Light travels with the eye: key from the upper left, a soft fill, a gentle rim.  The back of the body is then as
// well lit as its front, and relief reads the same from every side.
import { DirectionalLight, HemisphereLight, type Camera, type Object3D } from "three";

function lamp(camera: Camera, intensity: number, x: number, y: number, z: number): void {
  const light = new DirectionalLight(0xffffff, intensity);
  light.position.set(x, y, z);
  light.target.position.set(0, 0, -1);
  camera.add(light, light.target);
}

export function addLights(scene: Object3D, camera: Camera): void {
  scene.add(new HemisphereLight(0xffffff, 0xa9a39c, 1.25), camera);
  lamp(camera, 1.75, -1.1, 1.2, 0.6);
  lamp(camera, 0.4, 1.2, 0.1, 0.4);
  lamp(camera, 0.45, 0.6, 0.9, -2.2);
}
