//! Requests of `POST /v1/resolve` with certificates: random and adversarial problems, the golden cases and the examples.

use serde_json::{Map, Value, json};

use crate::problems::{self, EXTREME, Family, Random, SMALL, WIDE};
use revprio_core::resolution::{Method, Problem};

/// Names of all methods.
pub const METHODS: [&str; 6] = [
    "reverse_priority",
    "strict_reverse_priority",
    "task_priority",
    "singularity_robust",
    "pseudoinverse",
    "damped_least_squares",
];

/// Names of all solvers.
pub const SOLVERS: [&str; 3] = ["auto", "qp", "closed_form"];

/// A limit that stands for none. The limits of a request are finite.
const NO_LIMIT: f64 = 1e6;

/// Returns this request for every method and solver.
pub fn of_every_method_and_solver(request: &Map<String, Value>) -> Vec<Value> {
    let combinations = METHODS.iter().flat_map(|method| SOLVERS.iter().map(move |solver| (method, solver)));
    let request = |(method, solver)| {
        let mut request = request.clone();
        request.extend([("method".to_owned(), json!(method)), ("solver".to_owned(), json!(solver))]);
        Value::Object(request)
    };
    combinations.map(request).collect()
}

/// Returns a random problem of up to eight joints without method and solver: dependent, nearly dependent and zero rows, pinned
/// joints, corners of the box, inequality tasks, scaled tasks, inequalities, damping.
pub fn random_request(seed: u64) -> Map<String, Value> {
    let random = &mut Random::new(seed);
    let family = random.pick::<Family>(&[SMALL, SMALL, SMALL, WIDE, WIDE, EXTREME]);
    let problem = problems::problem(random, family, Method::ReversePriority);
    let n = problem.tasks.joint_count();
    let (has_bounds, has_scales) = (random.one_in(3), random.one_in(4));
    let tasks: Vec<Value> =
        (0..problem.tasks.tasks().len()).map(|k| task(random, &problem, k, has_bounds, has_scales)).collect();
    let mut request = object(&json!({"certificate": true, "tasks": tasks, "limits": limits(&problem)}));
    if let Some(zeta) = &problem.null_space_velocity {
        request.insert("null_space_velocity".to_owned(), json!(zeta.as_slice()));
    }
    if random.one_in(3) {
        let inequality = |inequality: &revprio_core::constraint::Inequality| json!({"kind": "joints", "coefficients": inequality.coefficients().as_slice(), "upper": inequality.bound()});
        let inequalities: Vec<Value> = problems::inequalities(random, n).iter().map(inequality).collect();
        request.insert("inequalities".to_owned(), json!(inequalities));
    }
    if random.one_in(3) {
        let damping = problems::damping(random);
        let damping = json!({"threshold": damping.threshold(), "max_factor": damping.max_factor()});
        request.insert("damping".to_owned(), damping);
    }
    request
}

fn task(random: &mut Random, problem: &Problem, k: usize, has_bounds: bool, has_scales: bool) -> Value {
    let task = &problem.tasks.tasks()[k];
    let jacobian: Vec<Vec<f64>> = task.jacobian.row_iter().map(|row| row.iter().copied().collect()).collect();
    let mut stated = object(&json!({"jacobian": jacobian}));
    if random.one_in(3) {
        stated.insert("name".to_owned(), json!(format!("own {k}")));
    }
    if has_bounds && random.one_in(2) {
        let bound = |random: &mut Random, value: f64| match random.below(4) {
            0 => (None, Some(value)),
            1 => (Some(value), None),
            // An equation among bounds.
            2 => (Some(value), Some(value)),
            _ => (Some(value), Some(value + random.unit().abs())),
        };
        let bounds: Vec<_> = task.lower.iter().map(|value| bound(random, *value)).collect();
        let (lower, upper): (Vec<_>, Vec<_>) = bounds.into_iter().unzip();
        stated.extend([("lower".to_owned(), json!(lower)), ("upper".to_owned(), json!(upper))]);
    } else {
        stated.insert("velocity".to_owned(), json!(task.lower.as_slice()));
        stated.insert("scale".to_owned(), json!(has_scales && random.one_in(2)));
    }
    Value::Object(stated)
}

fn limits(problem: &Problem) -> Value {
    let (lower, upper) = (problem.limits.lower(), problem.limits.upper());
    if lower.iter().chain(upper.iter()).all(|bound| bound.is_infinite()) {
        return json!("none");
    }
    let finite = |bound: &f64| bound.clamp(-NO_LIMIT, NO_LIMIT);
    json!({"lower": lower.iter().map(finite).collect::<Vec<_>>(), "upper": upper.iter().map(finite).collect::<Vec<_>>()})
}

/// Returns the golden cases: `fixtures/golden/README.md`.
pub fn golden_requests() -> Vec<Map<String, Value>> {
    let cases: Vec<Value> = serde_json::from_str(include_str!("../../fixtures/golden/resolution_cases.json")).unwrap();
    let request = |case: &Value| {
        let limits = json!({"lower": case["lower"], "upper": case["upper"]});
        object(&json!({"certificate": true, "tasks": case["tasks"], "limits": limits}))
    };
    cases.iter().map(request).collect()
}

/// Returns the examples of the interface, with `"certificate": true`.
pub fn examples() -> Vec<Value> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/api/examples");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_resolve = |path: &std::path::PathBuf| {
        path.is_file() && path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("resolve"))
    };
    let mut files: Vec<_> = files.filter(is_resolve).collect();
    files.sort();
    let request = |path: &std::path::PathBuf| {
        let mut request = object(&serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap());
        request.insert("certificate".to_owned(), json!(true));
        Value::Object(request)
    };
    files.iter().map(request).collect()
}

fn object(value: &Value) -> Map<String, Value> {
    value.as_object().unwrap().clone()
}
