// Commands that repeat one control cycle with curl or Python.

import { address, token } from './transport.js';

/** @typedef {import('./types.js').StepRequest} StepRequest */

/** @type {(request: StepRequest) => string} */
export function asCurl(request) {
  const header = token() ? ` -H "Authorization: Bearer $REVPRIO_TOKEN"` : '';
  const body = JSON.stringify(request).replaceAll("'", "'\\''");
  return `curl -s ${address()}/v1/step -H 'Content-Type: application/json'${header} -d '${body}'\n`;
}

/** @type {(request: StepRequest) => string} a program that needs only the standard library */
export function asPython(request) {
  const headers = token()
    ? `{"Content-Type": "application/json", "Authorization": "Bearer " + os.environ["REVPRIO_TOKEN"]}`
    : `{"Content-Type": "application/json"}`;
  return `import json${token() ? '\nimport os' : ''}
import urllib.request

cycle = json.loads(r'''${JSON.stringify(request).replaceAll("'", '\\u0027')}''')
request = urllib.request.Request("${address()}/v1/step", json.dumps(cycle).encode(), ${headers})
with urllib.request.urlopen(request) as response:
    answer = json.load(response)
print(answer["joint_velocity"])
`;
}

/** @type {(controller: StepRequest['controller']) => string} commands that start the ROS 2 node with the controller that is shown */
export function asRos2({ why: _, ...controller }) {
  return `cat > controller.json <<'END'
${JSON.stringify(controller)}
END
python3 -m revprio_ros.controller --ros-args -p controller:=controller.json -p url:=${address()}
`;
}
