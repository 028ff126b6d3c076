// Types of the service's bodies, with the names of the OpenAPI document. The tests generate `api.d.ts` from it.

import type { components } from './api';

export type Schemas = components['schemas'];
export type Scenario = Schemas['Scenario'];
export type ScenarioList = Schemas['ScenarioList'];
export type Controller = Schemas['Controller'];
export type Method = Schemas['Method'];
export type Solver = Schemas['Solver'];
export type Simulation = Schemas['Simulation'];
export type SimulationControl = Schemas['SimulationControl'];
export type SimulationRequest = Schemas['SimulationRequest'];
export type LiveFrame = Schemas['LiveFrame'];
export type LiveSample = Schemas['LiveSample'];
export type LiveContact = Schemas['LiveContact'];
export type ArmView = Schemas['ArmView'];
export type TimeHistogram = Schemas['TimeHistogram'];
export type PathCounts = Schemas['PathCounts'];
export type Robot = Schemas['Robot'];
export type RobotRegistration = Schemas['RobotRegistration'];
export type SessionList = Schemas['SessionList'];
export type SessionEntry = Schemas['SessionEntry'];
export type SessionStatus = Schemas['SessionStatus'];
export type WatchedStep = Schemas['WatchedStep'];
export type KinematicsAnswer = Schemas['KinematicsAnswer'];
export type StepAnswer = Schemas['StepAnswer'];
export type StepRequest = Schemas['StepRequest'];
export type ControllerTask = Schemas['ControllerTask'];
export type Contact = Schemas['Contact'];
export type Inequality = Schemas['Inequality'];
export type Profile = Schemas['Profile'];
export type TargetProgram = Schemas['TargetProgram'];
export type Pose = Schemas['Pose'];
export type Quaternion = Schemas['Orientation'];
export type Law = Schemas['Law'];
export type StreamedTarget = Schemas['StreamedTarget'];
export type RobotJoint = Schemas['RobotJoint'];
export type Axis = Schemas['Axis'];
export type RobotList = Schemas['RobotList'];
export type CollisionReport = Schemas['CollisionReport'];
export type ObstacleState = Schemas['ObstacleState'];
export type RoomObstacle = Schemas['RoomObstacle'];
export type LinkShape = Schemas['LinkShape'];
export type Problem = Schemas['Problem'];

export type Vec3 = [number, number, number];
