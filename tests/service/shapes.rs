//! Shapes of robots that come from their text, and what their semantic description leaves out.

use serde_json::{Value, json};

use crate::harness::Service;

/// Two arms of two joints on one table, with bodies; the right hand has a finger.
fn urdf() -> String {
    let arm = |side: &str, y: f64| {
        format!(
            r#"<link name="{side}_upper"><collision><origin xyz="0.2 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision></link>
            <link name="{side}_lower"><collision><origin xyz="0.15 0 0"/><geometry><box size="0.3 0.06 0.06"/></geometry></collision></link>
            <link name="{side}_hand"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
            <joint name="{side}_shoulder" type="revolute"><parent link="table"/><child link="{side}_upper"/><origin xyz="0 {y} 0.3"/>
              <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2" acceleration="8"/></joint>
            <joint name="{side}_elbow" type="revolute"><parent link="{side}_upper"/><child link="{side}_lower"/><origin xyz="0.4 0 0"/>
              <axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" velocity="2" acceleration="8"/></joint>
            <joint name="{side}_wrist" type="fixed"><parent link="{side}_lower"/><child link="{side}_hand"/><origin xyz="0.3 0 0"/></joint>"#
        )
    };
    format!(
        r#"<robot name="duo"><link name="table"><collision><geometry><box size="1 1 0.1"/></geometry></collision></link>{}{}
        <link name="finger"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
        <joint name="grip" type="prismatic"><parent link="right_hand"/><child link="finger"/><axis xyz="0 1 0"/>
          <limit lower="0" upper="0.04" velocity="0.1"/></joint></robot>"#,
        arm("left", 0.4),
        arm("right", -0.4)
    )
}

const SRDF: &str = r#"<robot name="duo">
  <end_effector name="l" parent_link="left_hand" group="l"/><end_effector name="r" parent_link="right_hand" group="r"/>
  <disable_collisions link1="table" link2="left_lower" reason="Never"/>
  <disable_collisions link1="table" link2="nothing" reason="Never"/></robot>"#;

fn register(service: &Service, change: &Value) -> Value {
    let mut robot = json!({"name": "duo", "urdf": urdf(), "shapes": "fit"});
    robot.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
    let created = service.post("/v1/robots", &robot.to_string());
    assert_eq!(created.status, 201, "{}", created.text);
    service.get("/v1/robots/duo").accepted()
}

#[test]
fn a_semantic_description_gives_tips_and_pairs_that_are_left_out() {
    let service = Service::start();
    let robot = register(&service, &json!({"srdf": SRDF}));
    assert_eq!(
        robot["tips"],
        json!([{"name": "left_hand", "link": "left_hand"}, {"name": "right_hand", "link": "right_hand"}])
    );
    assert_eq!(robot["joints"].as_array().unwrap().len(), 5);
    let left_out = robot["shapes"]["left_out"].as_array().unwrap();
    let disabled: Vec<&Value> = left_out.iter().filter(|pair| pair["reason"] == "Never").collect();
    assert_eq!(disabled.len(), 1, "{left_out:?}");
    assert_eq!(disabled[0]["links"], json!(["table", "left_lower"]));
    assert!(robot["shapes"].get("uncovered_links").is_none(), "the finger is a link of the tree");
}

#[test]
fn a_body_that_cannot_be_read_is_named_and_hides_no_other_one() {
    let service = Service::start();
    let post = |name: &str, urdf: String, change: Value| {
        let mut robot = json!({"name": name, "urdf": urdf, "tip": "right_hand"});
        robot.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        service.post("/v1/robots", &robot.to_string())
    };
    let turned = urdf().replacen(r#"rpy="0 1.5707963 0""#, r#"quat_xyzw="0 0.7071 0 0.7071""#, 2);
    let refused = post("turned", turned, json!({"shapes": "fit"}));
    refused.assert_refused(422, Some("/urdf"));
    assert!(refused.text.contains("`quat_xyzw` of <origin> is not supported"), "{}", refused.text);
    let odd = urdf().replace(r#"<sphere radius="0.05"/>"#, r#"<ellipsoid radii="1 2 3"/>"#);
    let listed = json!({"shape_list": [{"link": "right_lower", "body": "right_lower", "sphere": {"radius": 0.1}}]});
    let robot = post("odd", odd, listed).accepted();
    let uncovered = robot["shapes"]["uncovered_links"].as_array().unwrap();
    for link in ["table", "right_upper", "right_hand", "left_upper"] {
        assert!(uncovered.contains(&json!(link)), "{uncovered:?}");
    }
    assert!(!uncovered.contains(&json!("right_lower")), "{uncovered:?}");
}

#[test]
fn the_bodies_of_the_text_cover_the_links_and_what_they_miss_is_named() {
    let service = Service::start();
    let robot = register(&service, &json!({"tip": "right_hand"}));
    let shapes = robot["shapes"]["shape_list"].as_array().unwrap();
    let links: Vec<&str> = shapes.iter().map(|shape| shape["link"].as_str().unwrap()).collect();
    assert_eq!(links, ["table", "table", "table", "table", "right_upper", "right_lower", "right_hand"]);
    let radius = shapes[4]["capsule"]["radius"].as_f64().unwrap();
    assert!((0.05..0.06).contains(&radius), "{radius}");
    // The left arm and the finger are no part of the arm.
    assert_eq!(robot["shapes"]["uncovered_links"], json!(["left_upper", "left_lower", "left_hand", "finger"]));
    let controller = json!({"robot": "duo", "period_s": 0.004, "collisions": {},
        "tasks": [{"name": "hand", "axes": ["x"], "law": {"kind": "velocity", "target_velocity": {"kind": "constant", "value": [0]}}}]});
    let warnings = service.post("/v1/controllers", &controller.to_string()).json()["warnings"].to_string();
    assert!(warnings.contains("no shape covers the links") && warnings.contains("finger"), "{warnings}");
}

#[test]
fn stated_shapes_replace_those_of_their_links() {
    let service = Service::start();
    let stated = json!([{"link": "right_hand", "sphere": {"radius": 0.12}}]);
    let robot = register(&service, &json!({"tip": "right_hand", "shape_list": stated}));
    let shapes = robot["shapes"]["shape_list"].as_array().unwrap();
    let hands: Vec<&Value> = shapes.iter().filter(|shape| shape["link"] == "right_hand").collect();
    assert_eq!(hands.len(), 1);
    assert_eq!(hands[0]["sphere"]["radius"], 0.12);
}

#[test]
fn texts_that_cannot_be_fitted_or_read_are_refused_with_the_place() {
    let service = Service::start();
    let refused = |change: Value, pointer: &str, word: &str| {
        let mut robot = json!({"name": "duo", "urdf": urdf(), "tip": "right_hand"});
        robot.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        let answer = service.post("/v1/robots", &robot.to_string());
        answer.assert_refused(422, Some(pointer));
        assert!(answer.text.contains(word), "{}", answer.text);
    };
    let mesh = urdf().replace(r#"<sphere radius="0.05"/>"#, r#"<mesh filename="package://duo/hand.stl"/>"#);
    refused(json!({"shapes": "fit", "urdf": mesh}), "/shapes", "revprio robots fit");
    let bare = urdf().replace("collision>", "nothing>");
    refused(json!({"shapes": "fit", "urdf": bare}), "/shapes", "no link of the robot");
    let wrong = urdf().replace(r#"radius="0.05""#, r#"radius="-1""#);
    refused(json!({"shapes": "fit", "urdf": wrong}), "/urdf", "positive number");
    refused(json!({"srdf": "<sdf/>"}), "/srdf", "<sdf>");
    refused(json!({"shapes": "guess"}), "/shapes", "fit");
    refused(json!({"limits": {"left_shoulder": [[-1, 1], 2, 5, 7, null]}}), "/limits/left_shoulder", "give an object");
    refused(json!({"collision_pairs": {"leave_out": []}}), "/collision_pairs", "shape_list");
}

/// A link named like a frame cannot be a tip with its own name, and the request has no `tips` to point to.
#[test]
fn end_effectors_whose_links_cannot_name_tips_are_refused_at_their_text() {
    let service = Service::start();
    let robot =
        json!({"name": "duo", "urdf": urdf().replace("left_hand", "tool"), "srdf": SRDF.replace("left_hand", "tool")});
    let answer = service.post("/v1/robots", &robot.to_string());
    answer.assert_refused(422, Some("/srdf"));
    let elsewhere = json!({"name": "duo", "urdf": urdf(), "srdf": SRDF.replace("left_hand", "no_hand")});
    let answer = service.post("/v1/robots", &elsewhere.to_string());
    answer.assert_refused(422, Some("/srdf"));
    assert!(answer.text.contains("no_hand") && answer.text.contains("end effectors"), "{}", answer.text);
    assert!(answer.text.contains("state `tips` to name them otherwise"), "{}", answer.text);
}

/// A hand that is fixed to the tip: pairs of its own name are left out, those of the link that carries it are not those of the hand.
#[test]
fn pairs_and_shapes_of_a_link_are_not_those_of_what_is_fixed_to_it() {
    let text = urdf().replace(
        r#"<link name="finger">"#,
        r#"<link name="tool"/><joint name="flange" type="fixed"><parent link="right_lower"/><child link="tool"/></joint><link name="finger">"#,
    );
    let service = Service::start();
    let watched = |name: &str, more: &Value| {
        let mut robot = json!({"name": name, "urdf": text, "tip": "right_lower", "shapes": "fit"});
        robot.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        robot.as_object_mut().unwrap().retain(|_, value| !value.is_null());
        let created = service.post("/v1/robots", &robot.to_string());
        assert_eq!(created.status, 201, "{}", created.text);
        let robot = service.get(&format!("/v1/robots/{name}")).accepted();
        (robot["shapes"]["watched_pairs"].as_u64().unwrap(), robot["shapes"].clone())
    };
    let srdf = |links: [&str; 2]| {
        let [a, b] = links;
        json!({"srdf": format!("<robot name='duo'><disable_collisions link1='{a}' link2='{b}' reason='Never'/></robot>")})
    };
    let (all, _) = watched("all", &json!({}));
    let (without_lower, shapes) = watched("lower", &srdf(["table", "right_lower"]));
    let (without_hand, hand) = watched("hand", &srdf(["right_hand", "table"]));
    assert!(all > without_lower && all > without_hand, "{all}, {without_lower}, {without_hand}");
    assert_eq!(all - without_lower, all - without_hand, "four capsules of the table each");
    assert!(hand["left_out"].as_array().unwrap().iter().any(|pair| pair["reason"] == "Never"), "{hand}");
    for (name, links, fitted) in
        [("lower", ["table", "right_lower"], &shapes), ("hand", ["right_hand", "table"], &hand)]
    {
        let mut list = srdf(links);
        list["shapes"] = Value::Null;
        list["shape_list"] = fitted["shape_list"].clone();
        let (_, listed) = watched(&format!("listed_{name}"), &list);
        assert_eq!(&listed, fitted, "the list has the same pairs as the shapes that it lists");
        assert!(fitted["shape_list"].to_string().contains(r#""body":"right_hand""#), "{fitted}");
    }
    // A shape of the hand covers the hand alone.
    let only_hand = json!({"shapes": null, "shape_list": [{"link": "right_lower", "body": "right_hand", "sphere": {"radius": 0.1}}]});
    let (_, shapes_of_hand) = watched("only_hand", &only_hand);
    let bare = shapes_of_hand["uncovered_links"].to_string();
    assert!(bare.contains("right_lower") && !bare.contains("right_hand"), "{bare}");
    let other = json!([{"link": "right_upper", "body": "right_hand", "sphere": {"radius": 0.12}}]);
    let robot = json!({"name": "other", "urdf": text, "tip": "right_lower", "shape_list": other});
    service.post("/v1/robots", &robot.to_string()).assert_refused(422, Some("/shape_list/0/body"));
    let of_table = |pair: &Value| pair["links"] == json!(["table", "right_hand"]);
    assert!(!shapes["left_out"].as_array().unwrap().iter().any(of_table), "{shapes}");
    // A stated shape replaces the bodies of its own link, and not the hand that it carries.
    let stated = json!({"shape_list": [{"link": "right_lower", "sphere": {"radius": 0.01}}]});
    let (_, shapes) = watched("stated", &stated);
    let radii: Vec<f64> = shapes["shape_list"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|shape| shape["sphere"]["radius"].as_f64())
        .collect();
    assert_eq!(radii, [0.01, 0.05]);
}
