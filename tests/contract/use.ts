// Uses the generated TypeScript types; it is only compiled.
import type { components, paths } from "./api";

const state: components["schemas"]["State"] = { sequence: 1, time_s: 0, joint_position: [0, 0, 0, 0, 0, 0, 0] };
type Answer = paths["/v1/resolve"]["post"]["responses"]["200"]["content"]["application/json"];
export const speed = (answer: Answer): number => answer.joint_velocity[0] * state.time_s;
