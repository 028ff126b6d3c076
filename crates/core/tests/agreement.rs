//! The solvers of this crate and of `revprio-reference`, which share no arithmetic, over random and adversarial problems.

#[path = "resolution_properties/problems.rs"]
#[allow(dead_code)]
mod problems;

use problems::{EXTREME, Family, Random, SMALL, WIDE, damping, inequalities, problem, scaled, speed};
use revprio_core::resolution::{Method, Problem, Resolution, Resolver, Solve, Status};
use revprio_reference::Qp;

fn any_problem(random: &mut Random, family: Family, method: Method) -> Problem {
    let mut problem = problem(random, family, method);
    problem.damping = random.one_in(3).then(|| damping(random));
    if random.one_in(5) {
        problem.inequalities = inequalities(random, problem.tasks.joint_count());
    }
    if random.one_in(5) {
        let choice = random.bits();
        problem = scaled(&problem, |k| choice >> k & 1 == 1);
    }
    problem
}

fn percentile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[test]
fn table() {
    let count: u64 = std::env::var("N").ok().and_then(|n| n.parse().ok()).unwrap_or(2000);
    let methods = [
        Method::ReversePriority,
        Method::StrictReversePriority,
        Method::DampedLeastSquares,
        Method::Pseudoinverse,
        Method::SingularityRobust,
        Method::TaskPriority,
    ];
    let (mut qp, mut auto) = (Qp::default(), Resolver::default());
    for (name, family) in [("small", SMALL), ("wide", WIDE), ("extreme", EXTREME)] {
        for method in methods {
            let (mut errors, mut unsure, mut wrong, mut uncertain, mut auto_unsure) = (Vec::new(), 0, Vec::new(), 0, 0);
            let mut kinds = [0; 4];
            for seed in 0..count {
                let mut random = Random::new(seed);
                let problem = any_problem(&mut random, family, method);
                let (mut a, mut b) = (Resolution::default(), Resolution::default());
                qp.solve(&problem, &[], &mut a).unwrap();
                auto.solve(&problem, &[], &mut b).unwrap();
                let size = a.joint_velocity.amax().max(b.joint_velocity.amax()).max(speed(&problem)).max(1e-5);
                let error = (&a.joint_velocity - &b.joint_velocity).amax() / size;
                if b.solver.status != Status::Optimal {
                    auto_unsure += 1;
                }
                if a.solver.status != Status::Optimal {
                    unsure += 1;
                    kinds[0] += i32::from(problem.damping.is_some());
                    kinds[1] += i32::from(!problem.inequalities.is_empty());
                    kinds[2] += i32::from(problem.tasks.tasks().iter().any(|t| t.scaled));
                    kinds[3] += i32::from(a.solver.failures > 0);
                    if std::env::var("SHOW").is_ok() && unsure < 4 {
                        println!(
                            "   unsure {seed} {:?} damping {} ineq {} {:?}",
                            a.solver,
                            problem.damping.is_some(),
                            problem.inequalities.len(),
                            a.levels
                        );
                    }
                    continue;
                }
                if a.solver.rank_uncertain || b.solver.rank_uncertain {
                    uncertain += 1;
                    continue;
                }
                errors.push(error);
                if error > 1e-7 {
                    wrong.push((seed, error, problem.damping.is_some(), problem.inequalities.len()));
                }
            }
            errors.sort_by(f64::total_cmp);
            let above = |bar: f64| errors.iter().filter(|e| **e > bar).count();
            println!(
                "{name} {method:?}: median {:.1e} p99 {:.1e} worst {:.1e}; above 1e-9 {} 1e-7 {} 1e-5 {}; unsure {unsure} {kinds:?} rank uncertain {uncertain} auto unsure {auto_unsure}; {:?}",
                percentile(&errors, 0.5),
                percentile(&errors, 0.99),
                percentile(&errors, 1.0),
                above(1e-9),
                above(1e-7),
                above(1e-5),
                &wrong[..wrong.len().min(5)]
            );
        }
    }
}

#[test]
#[ignore]
fn show() {
    let seed: u64 = std::env::var("SEED").unwrap().parse().unwrap();
    let family = match std::env::var("FAMILY").unwrap().as_str() {
        "small" => SMALL,
        "wide" => WIDE,
        _ => EXTREME,
    };
    let method = match std::env::var("METHOD").unwrap().as_str() {
        "rp" => Method::ReversePriority,
        "strict" => Method::StrictReversePriority,
        "dls" => Method::DampedLeastSquares,
        "pinv" => Method::Pseudoinverse,
        "sr" => Method::SingularityRobust,
        _ => Method::TaskPriority,
    };
    let problem = if std::env::var("METHOD").unwrap() == "bulk" {
        let mut random = Random::new(seed);
        let method = random.pick(&[
            Method::ReversePriority,
            Method::ReversePriority,
            Method::StrictReversePriority,
            Method::DampedLeastSquares,
            Method::Pseudoinverse,
        ]);
        println!("{method:?}");
        any_problem(&mut random, family, method)
    } else {
        any_problem(&mut Random::new(seed), family, method)
    };
    println!("damping {:?} zeta {:?}", problem.damping, problem.null_space_velocity);
    println!("lower {:?}\nupper {:?}", problem.limits.lower().as_slice(), problem.limits.upper().as_slice());
    for t in problem.tasks.tasks() {
        println!("task scaled {} J {} v {:?}", t.scaled, t.jacobian, t.lower.as_slice());
    }
    for i in &problem.inequalities {
        println!("ineq {:?}", i);
    }
    let (mut a, mut b) = (Resolution::default(), Resolution::default());
    Qp::default().solve(&problem, &[], &mut a).unwrap();
    Resolver::default().solve(&problem, &[], &mut b).unwrap();
    for (n, r) in [("qp", &a), ("auto", &b)] {
        println!(
            "{n} {:?}\n  residuals {:?} scales {:?}\n  {:?}\n  active {:?} broken {:?}\n levels {:?}",
            r.joint_velocity.as_slice(),
            r.tasks.iter().map(|t| t.residual_norm).collect::<Vec<_>>(),
            r.tasks.iter().map(|t| t.scale).collect::<Vec<_>>(),
            r.solver,
            r.active_limits,
            r.violated_inequalities,
            r.levels.iter().filter(|l| l.residual > 1e-13).collect::<Vec<_>>()
        );
    }
}

#[test]
#[ignore]
fn show_plain() {
    let seed: u64 = std::env::var("SEED").unwrap().parse().unwrap();
    let problem = problem(
        &mut Random::new(seed),
        SMALL,
        [Method::ReversePriority, Method::StrictReversePriority][(seed % 2) as usize],
    );
    let (mut a, mut b) = (Resolution::default(), Resolution::default());
    println!("{:?} {:?}", problem.limits.lower().as_slice(), problem.limits.upper().as_slice());
    for t in problem.tasks.tasks() {
        println!("{} {:?}", t.jacobian, t.lower.as_slice());
    }
    Qp::default().solve(&problem, &[], &mut a).unwrap();
    Resolver::default().solve(&problem, &[], &mut b).unwrap();
    println!("qp {:?} {:?}\nauto {:?}", a.joint_velocity.as_slice(), a.solver, b.joint_velocity.as_slice());
}
