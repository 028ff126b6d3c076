//! Prints the worked example of `docs/solver.md`.
//!
//! Run with `cargo run -p revprio-core --example hierarchy`.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{ActiveSet, Method, Problem, Resolution, resolve};
use revprio_core::task::{Task, TaskStack};

type Error = Box<dyn std::error::Error>;

fn row(name: &str, row: [f64; 2], velocity: f64) -> Task {
    Task::new(name, Matrix::from_row_slice(1, 2, &row), Vector::from_element(1, velocity))
}

fn strict(
    tasks: Vec<Task>,
    upper: [f64; 2],
    damping: Option<Damping>,
    guess: &[ActiveSet],
) -> Result<Resolution, Error> {
    let limits = VelocityBox::new(&[-1.0, -1.0], &upper)?;
    let method = Method::StrictReversePriority;
    Ok(resolve(&Problem { limits, method, damping, ..Problem::new(TaskStack::new(tasks)?) }, guess)?)
}

/// Solves level 1: x_1 + 2 x_2 = 2, level 2: x_2 − x_1 = 2, with |x_1| ≤ 1 and −1 ≤ x_2 ≤ `upper`.
pub fn worked_example(upper: f64, guess: &[ActiveSet]) -> Result<Resolution, Error> {
    let tasks = vec![row("level 1", [1.0, 2.0], 2.0), row("level 2", [-1.0, 1.0], 2.0)];
    strict(tasks, [1.0, upper], None, guess)
}

/// Solves level 1: x_1 + ε x_2 = 1, level 2: x_2 = 0, with −1 ≤ x_1 ≤ 0.9 and |x_2| ≤ 1.
pub fn nearly_parallel(epsilon: f64, damping: Option<Damping>) -> Result<Resolution, Error> {
    strict(vec![row("level 1", [1.0, epsilon], 1.0), row("level 2", [0.0, 1.0], 0.0)], [0.9, 1.0], damping, &[])
}

fn print(name: &str, answer: &Resolution) {
    let residuals: Vec<f64> = answer.tasks.iter().map(|task| task.residual_norm).collect();
    let sets = answer.solver.working_sets;
    println!("{name:<22} x = {:7.4?}  residuals {residuals:.4?}  sets {sets}", answer.joint_velocity.as_slice());
    for (joint, limit) in answer.active_limits() {
        println!("{:<22} joint {} at {} with multiplier {:.4}", "", joint + 1, limit.value, limit.multiplier);
    }
}

/// Prints both tables of the page.
pub fn main() -> Result<(), Error> {
    let limited = worked_example(1.0, &[])?;
    print("x_2 at most 2", &worked_example(2.0, &[])?);
    print("x_2 at most 1", &limited);
    print("x_2 at most 1, warm", &worked_example(1.0, &limited.active_set)?);
    println!("\n     ε   x_2 exact   x_2 damped   level 1 damped");
    for epsilon in [0.2, 0.11, 0.105, 0.102, 0.1, 0.05, 0.01, 0.001, 0.0, -0.001, -0.01, -0.1] {
        let (exact, damped) = (nearly_parallel(epsilon, None)?, nearly_parallel(epsilon, Some(Damping::STANDARD))?);
        let [exact, residual] = [exact.joint_velocity[1], damped.tasks[0].residual_norm];
        println!("{epsilon:6.3}   {exact:9.4}   {:10.4}   {residual:14.4}", damped.joint_velocity[1]);
    }
    Ok(())
}
