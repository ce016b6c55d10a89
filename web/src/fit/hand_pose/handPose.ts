// The model posed by hand, only to look at: a copy of the fit's last pose with some sliders moved.  Numbers, files and
// the next fit know nothing of it.
import type { NodePose } from "../../api/types";

export interface HandPose {
  readonly fit: string; // the fit whose pose it is a copy of
  readonly nodes: readonly NodePose[];
}

/** A bone's size is in a node of its own below the joint, so that it is not handed on to the next bone. */
const scaleNode = (bone: string): string => `${bone}_scale`;

export type Axis = 0 | 1 | 2;

export function scaleOf(nodes: readonly NodePose[], bone: string, axis: Axis): number | null {
  return nodes.find(({ name }) => name === scaleNode(bone))?.scale?.[axis] ?? null;
}

export function withScale(nodes: readonly NodePose[], bone: string, axis: Axis, value: number): NodePose[] {
  return nodes.map((node) => (node.name === scaleNode(bone) && node.scale ? { ...node, scale: node.scale.map((old, i) => (i === axis ? value : old)) } : node));
}

export function weightOf(nodes: readonly NodePose[], shape: number): number | null {
  return nodes.find(({ weights }) => weights)?.weights?.[shape] ?? null;
}

export function withWeight(nodes: readonly NodePose[], shape: number, value: number): NodePose[] {
  return nodes.map((node) => (node.weights ? { ...node, weights: node.weights.map((old, i) => (i === shape ? value : old)) } : node));
}
