//! `--robot`

use serde_json::Value;

use crate::program::{Scratch, failure, program, success};
use crate::serve::Server;
use crate::trace::Trace;

/// An arm of three links with a tool and a camera on the last one.
fn camera_arm() -> String {
    let text = include_str!("../../fixtures/robots/planar_3r.urdf");
    let camera = r#"<link name="camera"/>
  <joint name="clamp" type="fixed"><parent link="hand"/><child link="camera"/></joint>
</robot>"#;
    text.replace("</robot>", camera).replace(r#"name="planar_3r""#, r#"name="camera_arm""#)
}

fn planar() -> String {
    include_str!("../../fixtures/robots/planar_3r.urdf").to_owned()
}

const SECOND_ARM: &str = r#"<link name="arm2"/><link name="b2"/>
  <joint name="i" type="continuous"><parent link="base"/><child link="arm2"/></joint>
  <joint name="k" type="continuous"><parent link="arm2"/><child link="b2"/></joint>"#;

/// A scenario of 0.2 s: push against a spring in x.
fn push(robot: &str) -> String {
    format!(
        r#"
name = "planar_push"
description = "a planar arm pushes against a spring"
duration_s = 0.2
start_joint_position = [0.4, 0.9, -0.7]
[[contacts]]
axis = "x"
kind = "spring"
stiffness = 1000.0
[controller]
robot = "{robot}"
period_s = 0.001
[[controller.tasks]]
name = "push"
axes = ["x"]
law = {{ kind = "force", inertia = [15.0], damping = [150.0], target_force = {{ kind = "constant", value = [5.0] }} }}
"#
    )
}

fn trace(scratch: &Scratch, out: &str) -> Vec<u8> {
    let path = scratch.path().join(out).join("planar_push-strict_reverse_priority-auto.csv");
    assert_eq!(Trace::read(&path).rows(), 200);
    std::fs::read(path).unwrap()
}

#[test]
fn own_robot_is_simulated_with_and_without_a_server() {
    let (scratch, server) = (Scratch::new("robot"), Server::start());
    let built_in = scratch.write("built_in.toml", &push("planar_3r"));
    success(&["simulate", &built_in, "--out", &scratch.argument("built_in")]);
    let expected = trace(&scratch, "built_in");

    let scenario = scratch.write("push.toml", &push("whatever"));
    let robot = scratch.write("arm.urdf", &camera_arm()) + ",tip=tool";
    success(&["simulate", &scenario, "--robot", &robot, "--out", &scratch.argument("own")]);
    assert!(trace(&scratch, "own") == expected);
    // Twice, because the robot is removed from the server after each run.
    for out in ["server", "again"] {
        let options = ["--robot", &robot, "--server", &server.url, "--out", &scratch.argument(out)];
        success(&[&["simulate", &scenario][..], &options].concat());
        assert!(trace(&scratch, out) == expected);
    }
}

#[test]
fn errors_of_robot_registration_name_the_remedy() {
    let (scratch, server) = (Scratch::new("robot_failures"), Server::start());
    let scenario = scratch.write("push.toml", &push("whatever"));
    let urdf = scratch.write("arm.urdf", &camera_arm());
    let simulate = |robot: &str| failure(&["simulate", &scenario, "--robot", robot, "--server", &server.url]);
    let two = planar().replace("</robot>", &format!("{SECOND_ARM}</robot>")).replace("planar_3r", "two_arms");
    let two = scratch.write("two.urdf", &two);
    let message = simulate(&two);
    assert!(message.contains("2 arms; name the `tip`: `tool`, `b2`"), "{message}");
    let message = simulate(&format!("{urdf},tip=tool,name=panda"));
    assert!(message.contains("has another robot `panda`") && message.contains("name=NAME"), "{message}");
    let rows = include_str!("../../fixtures/robots/sawyer_dh.toml");
    let mine = scratch.write("rows.toml", &rows.replace(r#"name = "sawyer_dh""#, r#"name = "mine""#));
    assert!(simulate(&mine).contains("revprio serve --robot"));
    let unknown = failure(&["simulate", &scenario]);
    assert!(unknown.contains("no robot `whatever`"), "{unknown}");
}

#[test]
fn own_robots_are_served_with_the_built_in_ones() {
    let scratch = Scratch::new("served_robot");
    let urdf = scratch.write("arm.urdf", &camera_arm()) + ",tip=camera,name=mine";
    let rows = include_str!("../../fixtures/robots/sawyer_dh.toml").to_owned();
    let toml = scratch.write("rows.toml", &rows) + ",name=rows";
    let server = Server::start_with(&["--robot", &urdf, "--robot", &toml]);
    let answer = server.get("/v1/robots");
    let robots = answer.split_once("\r\n\r\n").unwrap().1;
    let robots: Value = serde_json::from_str(robots).unwrap();
    let names: Vec<&str> = robots["robots"].as_array().unwrap().iter().map(|r| r["name"].as_str().unwrap()).collect();
    let built_in = ["sawyer_dh", "sawyer", "ur5e", "panda", "planar_3r", "so101", "fr3", "xarm7", "iiwa14", "gen3"];
    assert_eq!(names, [&built_in[..], &["mine", "rows"]].concat());
}

#[test]
fn overrides_are_read_from_a_file() {
    let scratch = Scratch::new("overrides");
    let urdf = scratch.write("arm.urdf", &camera_arm());
    let overrides = r#"{"limits": {"shoulder": {"velocity": 0.125}}, "joint_names": {"shoulder": "swing"}}"#;
    let json = scratch.write("my.json", overrides);
    let server = Server::start_with(&["--robot", &format!("{urdf},name=mine,overrides={json}")]);
    let answer = server.get("/v1/robots/mine");
    let robot: Value = serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap();
    assert_eq!(
        (robot["joints"][0]["name"].as_str(), robot["joints"][0]["velocity_limit"].as_f64()),
        (Some("swing"), Some(0.125))
    );
    assert_eq!((robot["chain"]["tip"].as_str(), robot["chain"]["reason"].as_str()), (Some("tool"), Some("tool_name")));

    let serve = |overrides: &str| {
        let file = scratch.write("wrong.json", overrides);
        failure(&["serve", "--listen", "127.0.0.1:0", "--robot", &format!("{urdf},overrides={file}")])
    };
    assert!(serve("{").contains("wrong.json"));
    assert!(serve(r#"{"limit": {}}"#).contains("there is no field `limit`; did you mean `limits`?"));
    let twice = r#"{"shoulder": {"velocity": 1}, "shoulder": {"velocity": 5}}"#;
    assert!(serve(&format!(r#"{{"limits": {twice}}}"#)).contains("`shoulder` is given twice"));
    assert!(serve(r#"{"joint_names": {"shoulder": "a", "shoulder": "b"}}"#).contains("`shoulder` is given twice"));
    assert!(serve(r#"{"limits": {"nose": {}}}"#).contains("`limits` has a joint `nose`"));
    let shapes = scratch.write("shapes.json", r#"{"shape_list": [{"link": "j4", "sphere": {"radius": 0.1}}]}"#);
    let shown = success(&["robots", "check", &format!("fixtures/robots/sawyer_dh.toml,name=rows,overrides={shapes}")]);
    assert!(shown.contains("Shapes: 1 capsules"), "{shown}");
    let rows = format!("fixtures/robots/sawyer_dh.toml,overrides={json}");
    assert!(failure(&["serve", "--robot", &rows]).contains("`base` and `tip` are for .urdf"));
}

#[test]
fn errors_name_robot_files_that_cannot_be_served() {
    let scratch = Scratch::new("robot_files");
    let serve = |robot: &str| failure(&["serve", "--listen", "127.0.0.1:0", "--robot", robot]);
    assert!(serve("none.urdf").contains("cannot read none.urdf"));
    assert!(serve("README.md").contains("README.md: robots are described in .urdf, .toml or .json"));
    assert!(serve("fixtures/robots/panda.urdf").contains("the name `panda` is taken"));
    assert!(serve("fixtures/robots/sawyer_dh.toml,tip=tool").contains("`base` and `tip` are for .urdf"));
    let broken = scratch.write("broken.urdf", "<robot name='r'>");
    assert!(serve(&broken).contains(&broken));
    let spaced = scratch.write("spaced.urdf", &camera_arm().replace("camera_arm", "two words"));
    let message = serve(&(spaced + ",tip=tool"));
    assert!(message.contains("`two words` cannot name a robot") && message.contains("name=NAME"), "{message}");
    let output = program(&["serve", "--robot", "a.urdf,tool=b"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn simulate_warns_about_an_unstable_contact() {
    let scratch = Scratch::new("warned");
    let lag = |periods: u32, lag: f64| {
        let text = push("planar_3r").replace("stiffness = 1000.0", "stiffness = 1e5");
        format!("{text}[velocity_loop]\nlag_s = {lag}\ndelay_periods = {periods}\n")
    };
    let warnings = |name: &str, text: &str| {
        let file = scratch.write(name, text);
        let output = program(&["simulate", &file, "--out", &scratch.argument("out")]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stderr).unwrap()
    };
    let warned = warnings("lag.toml", &lag(0, 0.005));
    assert!(warned.contains("warning: task `push`, axis x: ") && warned.contains("unstable"), "{warned}");
    // Where stability is not checked, all else is.
    let grams = "[controller.wrench_sensor]\npayload = {mass_kg = 200.0}\n";
    let warned = warnings("far.toml", &(lag(40, 0.0) + grams));
    assert!(warned.contains("warning: stability is not checked") && warned.contains("200 kg are more"), "{warned}");
    assert!(!warnings("calm.toml", &push("planar_3r")).contains("warning"));
}

#[test]
fn tips_beside_the_file_make_a_robot_of_all_arms() {
    let scratch = Scratch::new("robot_tips");
    let registration: Value = serde_json::from_str(include_str!("../../api/examples/robot_two_arms.json")).unwrap();
    let urdf = scratch.write("two.urdf", registration["urdf"].as_str().unwrap());
    let mut overrides = serde_json::json!({"tips": registration["tips"], "limits": registration["limits"]});
    let tips = scratch.write("tips.json", &overrides.to_string());
    let shown = success(&["robots", "check", &format!("{urdf},overrides={tips}")]);
    assert!(shown.contains("joints 7") && shown.contains("right_wrist"), "{shown}");
    let both = failure(&["robots", "check", &format!("{urdf},tip=left_hand,overrides={tips}")]);
    assert!(both.contains("give either `tip` or `tips`"), "{both}");
    let three = scratch.write("three.json", r#"{"limits": {"elbow": {"position": [-1, 1, 2]}}}"#);
    let refused = failure(&["robots", "check", &format!("{urdf},overrides={three}")]);
    assert!(refused.contains("/limits/elbow/position: give a list of 2 entries, not of 3"), "{refused}");
    overrides["tips"][1]["name"] = "tool".into();
    let taken = scratch.write("taken.json", &overrides.to_string());
    let refused = failure(&["robots", "check", &format!("{urdf},overrides={taken}")]);
    assert!(refused.contains("`tool` is the name of"), "{refused}");
}

#[test]
fn check_refuses_the_names_that_serve_refuses() {
    let named = |name: &str| format!("examples/robots/duo.urdf,tip=left_hand,name={name}");
    for name in ["my arm", "a/b", "", "panda"] {
        let refused = failure(&["robots", "check", &named(name)]);
        assert!(refused.contains("write `FILE,name=NAME`"), "{name}: {refused}");
        // `serve` writes its log before the error.
        let served = failure(&["serve", "--listen", "127.0.0.1:0", "--robot", &named(name)]);
        assert!(served.ends_with(&refused), "{served}");
    }
    assert!(success(&["robots", "check", &named("my_duo")]).contains("my_duo: joints"));
}

/// A cube of 0.1 m in the format STL.
fn cube() -> String {
    let corner = |k: usize| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|bit| if bit == 1 { "0.1" } else { "0" }).join(" ");
    let faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 3, 7],
        [1, 7, 5],
    ];
    let facet = |face: [usize; 3]| {
        let vertices = face.map(|k| format!("vertex {}\n", corner(k))).concat();
        format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid cube\n{}endsolid cube\n", faces.map(facet).concat())
}

#[test]
fn capsules_contain_the_meshes_of_a_file_and_are_printed_for_a_registration() {
    let scratch = Scratch::new("robot_fit");
    scratch.write("cube.stl", &cube());
    let link = r#"<link name="hand"><collision><geometry><mesh filename="cube.stl" scale="2 2 2"/></geometry></collision></link>
      <link name="camera"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>"#;
    let text = format!(
        r#"<robot name="boxer"><link name="base"/>{link}<joint name="turn" type="continuous"><parent link="base"/><child link="hand"/>
        <axis xyz="0 0 1"/><limit velocity="1"/></joint><joint name="eye" type="fixed"><parent link="hand"/><child link="camera"/></joint></robot>"#
    );
    let urdf = scratch.write("boxer.urdf", &text);
    let printed: Value = serde_json::from_str(&success(&["robots", "fit", &format!("{urdf},tip=hand")])).unwrap();
    let shapes = printed["shape_list"].as_array().unwrap();
    assert_eq!((shapes.len(), shapes[0]["link"].as_str()), (1, Some("hand")));
    // The ball around a cube of 0.2 m, at the least.
    let radius = shapes[0]["sphere"]["radius"].as_f64().or(shapes[0]["capsule"]["radius"].as_f64()).unwrap();
    assert!((0.14..0.19).contains(&radius), "{shapes:?}");
    let fitted = scratch.write("shapes.json", &printed.to_string());
    let shown = success(&["robots", "check", &format!("{urdf},tip=hand,overrides={fitted}")]);
    assert!(shown.contains("Shapes: 1 capsules"), "{shown}");
    let shown = success(&["robots", "check", &format!("{urdf},tip=hand,shapes=fit")]);
    assert!(shown.contains("No shape covers camera"), "{shown}");
    let server = Server::start_with(&["--robot", &format!("{urdf},tip=hand,shapes=fit")]);
    assert!(server.get("/v1/robots/boxer").contains("uncovered_links"));
    std::fs::remove_file(scratch.argument("cube.stl")).unwrap();
    let missing = failure(&["robots", "fit", &format!("{urdf},tip=hand")]);
    assert!(missing.contains("the mesh cube.stl is not found"), "{missing}");
}

#[test]
fn a_semantic_description_beside_the_file_gives_its_tips() {
    let duo = "examples/robots/duo.urdf,srdf=examples/robots/duo.srdf,shapes=fit";
    let shown = success(&["robots", "check", duo]);
    assert!(shown.contains("joints 13") && shown.contains("Tips, first the tool: left_hand, right_hand."), "{shown}");
    assert!(failure(&["robots", "check", "examples/robots/duo.urdf,srdf=none.srdf"]).contains("cannot read none.srdf"));
}
