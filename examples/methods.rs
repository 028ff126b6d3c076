//! Compares the methods for two tasks with opposite velocities along directions that converge.
//!
//! `cargo run --example methods` prints the numbers of `docs/methods.md` and draws `docs/methods.svg`.

use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Solve};
use revprio_core::task::{Task, TaskStack};
use revprio_lab::report::figure::{Colour, Curve, Figure, Panel, Stroke};
use revprio_reference::ClosedForm;

/// Largest speed in the figure, rad/s. Undamped speeds grow like 1/ε.
const MAX_SPEED: f64 = 60.0;

type Error = Box<dyn std::error::Error>;

/// A method with its damping, and the style of its curve.
struct Variant {
    method: Method,
    damping: Option<Damping>,
    label: &'static str,
    colour: Colour,
    stroke: Stroke,
}

const VARIANTS: [Variant; 5] = [
    variant(Method::TaskPriority, None, "task priority", Colour::Orange, Stroke::Wide),
    variant(Method::ReversePriority, None, "reverse priority, exact", Colour::Black, Stroke::Dashed),
    variant(Method::DampedLeastSquares, Some(Damping::STANDARD), "damped least squares", Colour::Blue, Stroke::Thin),
    variant(Method::SingularityRobust, None, "singularity-robust", Colour::Green, Stroke::Thin),
    variant(
        Method::ReversePriority,
        Some(Damping::STANDARD),
        "reverse priority, damped",
        Colour::Vermillion,
        Stroke::Wide,
    ),
];

const fn variant(
    method: Method,
    damping: Option<Damping>,
    label: &'static str,
    colour: Colour,
    stroke: Stroke,
) -> Variant {
    Variant { method, damping, label, colour, stroke }
}

fn row(entries: &[f64], velocity: f64) -> Task {
    Task::new("", Matrix::from_row_slice(1, entries.len(), entries), Vector::from_element(1, velocity))
}

fn solve(tasks: Vec<Task>, method: Method, damping: Option<Damping>) -> Result<Resolution, Error> {
    let problem = Problem { method, damping, ..Problem::new(TaskStack::new(tasks)?) };
    let mut answer = Resolution::default();
    ClosedForm.solve(&problem, &[], &mut answer)?;
    Ok(answer)
}

/// Resolves two tasks: velocity 1 along a direction, and −1 along a direction at an angle of `degrees` to it.
fn opposed(variant: &Variant, degrees: f64) -> Result<Resolution, Error> {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    solve(vec![row(&[1.0, 0.0, 0.0], 1.0), row(&[cosine, sine, 0.0], -1.0)], variant.method, variant.damping)
}

fn panel(heading: &str, y_label: &str, value: impl Fn(&Resolution) -> f64) -> Result<Panel, Error> {
    let mut curves = Vec::new();
    for variant in &VARIANTS {
        let mut points = Vec::new();
        // The angles exclude zero, where the tasks contradict each other exactly and exact methods drop the second one.
        for i in -400..400 {
            let degrees = 0.025 * (f64::from(i) + 0.5);
            points.push((degrees, value(&opposed(variant, degrees)?).min(MAX_SPEED)));
        }
        curves.push(Curve { label: variant.label.to_owned(), colour: variant.colour, stroke: variant.stroke, points });
    }
    Ok(Panel {
        heading: heading.to_owned(),
        x_label: "angle between the directions of the two tasks (°)".to_owned(),
        y_label: y_label.to_owned(),
        window: (-10.0, 10.0),
        y_covers: Vec::new(),
        curves,
    })
}

fn picture() -> Result<String, Error> {
    let figure = Figure {
        name: "methods".to_owned(),
        title: "Two tasks that come into conflict".to_owned(),
        caption: String::new(),
        panels: vec![
            panel("(a) Joint speed", "‖q̇‖ (rad/s), cut off at 60", |answer| answer.joint_velocity.norm())?,
            panel("(b) Residual of task 1", "residual (rad/s)", |answer| answer.tasks[0].residual_norm)?,
            panel("(c) Residual of task 2", "residual (rad/s)", |answer| answer.tasks[1].residual_norm)?,
        ],
    };
    Ok(revprio_lab::report::svg(&figure)?)
}

fn numbers() -> Result<(), Error> {
    println!("two tasks, 1° apart       ‖q̇‖     task 1     task 2");
    for variant in &VARIANTS {
        let answer = opposed(variant, 1.0)?;
        let [one, two] = [0, 1].map(|k| answer.tasks[k].residual_norm);
        println!("{:<24}{:>7.3}{one:>11.2e}{two:>11.2e}", variant.label, answer.joint_velocity.norm());
    }
    println!("\nJ_1 = b + c, J_2 = b, J_3 = c, ẋ = (1, 0, 0)       residuals");
    for method in [Method::ReversePriority, Method::StrictReversePriority, Method::TaskPriority] {
        let tasks = vec![row(&[1.0, 1.0], 1.0), row(&[1.0, 0.0], 0.0), row(&[0.0, 1.0], 0.0)];
        let answer = solve(tasks, method, None)?;
        let residuals: Vec<String> = answer.tasks.iter().map(|task| format!("{:.3}", task.residual_norm)).collect();
        println!("{:<50}{}", format!("{method:?}"), residuals.join("  "));
    }
    Ok(())
}

fn main() -> Result<(), Error> {
    numbers()?;
    std::fs::write("docs/methods.svg", picture()?)?;
    Ok(())
}
