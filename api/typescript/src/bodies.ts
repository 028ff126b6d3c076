/** Types of request and answer bodies, with the names of the OpenAPI document. */
import type { components } from "./generated.js";

type Schemas = components["schemas"];

export type Axis = Schemas["Axis"];
export type ChunkAction = Schemas["ChunkAction"];
export type Controller = Schemas["Controller"];
export type ControllerTask = Schemas["ControllerTask"];
export type CreatedController = Schemas["CreatedController"];
export type Frame = Schemas["Frame"];
export type KinematicsAnswer = Schemas["KinematicsAnswer"];
export type KinematicsRequest = Schemas["KinematicsRequest"];
export type Law = Schemas["Law"];
export type Memory = Schemas["Memory"];
export type PayloadAnswer = Schemas["PayloadAnswer"];
export type PayloadRequest = Schemas["PayloadRequest"];
export type Problem = Schemas["Problem"];
export type ResolveAnswer = Schemas["ResolveAnswer"];
export type ResolveRequest = Schemas["ResolveRequest"];
export type ResolveTask = Schemas["ResolveTask"];
export type Robot = Schemas["Robot"];
export type RobotRegistration = Schemas["RobotRegistration"];
export type Scenario = Schemas["Scenario"];
export type ScenarioEntry = Schemas["ScenarioEntry"];
export type SessionEntry = Schemas["SessionEntry"];
export type SessionStatus = Schemas["SessionStatus"];
export type Simulation = Schemas["Simulation"];
export type SimulationControl = Schemas["SimulationControl"];
export type SimulationRequest = Schemas["SimulationRequest"];
export type StabilityAnswer = Schemas["StabilityAnswer"];
export type StabilityRequest = Schemas["StabilityRequest"];
export type State = Schemas["State"];
export type StepAnswer = Schemas["StepAnswer"];
export type StepRequest = Schemas["StepRequest"];
export type StreamedTarget = Schemas["StreamedTarget"];
export type Streaming = Schemas["Streaming"];
export type TareAnswer = Schemas["TareAnswer"];
export type TareRequest = Schemas["TareRequest"];
export type Wrench = Schemas["Wrench"];
export type WrenchSensor = Schemas["WrenchSensor"];

/** Measured values of one period: a state without its number. Default of `time_s`: sequence number times period. */
export type Measurement = Omit<State, "sequence" | "time_s"> & { time_s?: number };
