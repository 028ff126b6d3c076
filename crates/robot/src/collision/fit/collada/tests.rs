//! Two geometries in a scene: what is placed where, and what is refused.

use nalgebra::Vector3;

use super::{ColladaError, read};

/// A file with this scene. Its unit is 10 mm; `square` has the corners (0, 0), (1, 0), (1, 1), (0, 1) at z = 0.
fn file(primitive: &str, scene: &str) -> String {
    format!(
        r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
        <asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
        <library_geometries><geometry id="square"><mesh>
          <source id="corners"><float_array id="list" count="17">9 0 0 0 8 1 0 0 8 1 1 0 8 0 1 0 8</float_array>
            <technique_common><accessor source="#list" count="4" stride="4" offset="1"/></technique_common></source>
          <vertices id="points"><input semantic="POSITION" source="#corners"/></vertices>
          {primitive}
        </mesh></geometry></library_geometries>
        <library_nodes><node id="other"><translate>0 0 5</translate><instance_geometry url="#square"/></node>
          <node id="again"><instance_node url="#again"/></node></library_nodes>
        <library_visual_scenes><visual_scene id="all">{scene}</visual_scene></library_visual_scenes>
        <scene><instance_visual_scene url="#all"/></scene></COLLADA>"##
    )
}

const POLYGON: &str = r##"<polylist count="1"><input semantic="VERTEX" source="#points" offset="1"/>
    <input semantic="NORMAL" source="#none" offset="0"/><vcount>4</vcount><p>7 0 7 1 7 2 7 3</p></polylist>"##;

const PLAIN: &str = r##"<node><instance_geometry url="#square"/></node>"##;

/// Returns the corners in their order, m.
fn corners(text: &str) -> Vec<Vector3<f64>> {
    read(text).unwrap().into_iter().flatten().collect()
}

#[test]
fn every_kind_of_primitive_gives_the_same_square() {
    let input = r##"<input semantic="VERTEX" source="#points" offset="0"/>"##;
    for primitive in [
        POLYGON.to_owned(),
        format!("<triangles>{input}<p>0 1 2 0 2 3</p></triangles>"),
        format!("<trifans>{input}<p>0 1 2 3</p></trifans>"),
        format!("<tristrips>{input}<p>1 2 0 3</p></tristrips>"),
        format!("<polygons>{input}<p>0 1 2</p><ph><p>0 2 3</p></ph></polygons>"),
        format!(
            "<lines>{input}<p>0 1</p></lines><triangles>{input}<p>0 1 2</p></triangles><triangles>{input}<p>0 2 3</p></triangles>"
        ),
    ] {
        let triangles = read(&file(&primitive, PLAIN)).unwrap();
        let area = triangles.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0).sum::<f64>();
        assert_eq!(triangles.len(), 2, "{primitive}");
        assert!((area - 1e-4).abs() < 1e-18, "{primitive}: {area}");
    }
}

#[test]
fn nodes_place_their_geometry_as_often_as_they_name_it() {
    let scene = r##"<node><translate>1 0 0</translate><rotate>0 0 1 90</rotate>
        <node><scale>2 2 2</scale><instance_geometry url="#square"/></node>
        <node><matrix>1 0 0 0  0 1 0 0  0 0 1 3  0 0 0 1</matrix><instance_geometry url="#square"/></node>
        <instance_node url="#other"/></node>"##;
    let seconds: Vec<Vector3<f64>> = corners(&file(POLYGON, scene)).into_iter().skip(1).step_by(6).collect();
    // The second corner of the square, (1, 0, 0), turned to y, scaled, moved and in metres.
    let expected =
        [[1.0, 2.0, 0.0], [1.0, 1.0, 3.0], [1.0, 1.0, 5.0]].map(|point: [f64; 3]| 0.01 * Vector3::from(point));
    assert_eq!(seconds.len(), expected.len());
    for (point, expected) in seconds.iter().zip(expected) {
        assert!((point - expected).norm() < 1e-15, "{point} {expected}");
    }
}

#[test]
fn a_file_without_a_scene_gives_all_geometries() {
    let text = file(POLYGON, "");
    let (start, _) = text.split_once("<library_nodes>").unwrap();
    assert_eq!(read(&format!("{start}</COLLADA>")).unwrap().len(), 2);
    assert_eq!(read("<COLLADA/>").unwrap().len(), 0);
}

/// Which scene counts, `<scene>` says; the only one counts without it.
#[test]
fn a_scene_that_is_not_named_counts_if_it_is_the_only_one() {
    let moved = r##"<node><translate>0 0 50</translate><instance_geometry url="#square"/></node>"##;
    let text = file(POLYGON, moved).replace(r##"<scene><instance_visual_scene url="#all"/></scene>"##, "");
    assert_eq!(corners(&text), corners(&file(POLYGON, moved)));
    assert!((corners(&text)[0].z - 0.5).abs() < 1e-12);
    let two = text.replace("</library_visual_scenes>", r#"<visual_scene id="more"/></library_visual_scenes>"#);
    assert_eq!(read(&two).unwrap_err(), ColladaError::Unsupported("visual_scene".to_owned()));
}

#[test]
fn what_could_stand_elsewhere_is_refused() {
    let refused = |primitive: &str, scene: &str| read(&file(primitive, scene)).unwrap_err();
    let unsupported = |name: &str| ColladaError::Unsupported(name.to_owned());
    assert_eq!(refused(POLYGON, "<node><skew>1 0 0 0 1 0 0</skew></node>"), unsupported("skew"));
    assert_eq!(
        refused(POLYGON, r##"<node><instance_controller url="#x"/></node>"##),
        unsupported("instance_controller")
    );
    assert_eq!(refused(POLYGON, r##"<node><instance_node url="#again"/></node>"##), ColladaError::TooLarge);
    let metres = |meter: &str| format!(r#"<node><asset><unit meter="{meter}"/></asset>{PLAIN}</node>"#);
    assert_eq!(refused(POLYGON, &metres("1")), unsupported("unit"));
    assert!(read(&file(POLYGON, &metres("0.01"))).is_ok());
    let elsewhere = refused(POLYGON, r#"<node><instance_geometry url="other.dae#square"/></node>"#);
    assert!(matches!(elsewhere, ColladaError::Reference { .. }), "{elsewhere}");
    for transform in ["<matrix>1 2</matrix>", "<translate>a b c</translate>", "<rotate>0 0 0 90</rotate>"] {
        let error = refused(POLYGON, &format!("<node>{transform}</node>"));
        assert!(matches!(error, ColladaError::Numbers(_)), "{error}");
    }
    let far = POLYGON.replace("7 3<", "7 4<");
    assert_eq!(refused(&far, PLAIN), ColladaError::Corner { index: 4, count: 4 });
    let short = POLYGON.replace("<vcount>4<", "<vcount>5<");
    assert_eq!(refused(&short, PLAIN), ColladaError::Numbers("vcount".to_owned()));
    assert!(matches!(read("<COLLADA>"), Err(ColladaError::Xml(_))));
    assert_eq!(read("<robot/>"), Err(ColladaError::Root("robot".to_owned())));
}

#[test]
fn a_comment_inside_a_list_drops_no_number() {
    let commented = POLYGON.replace("7 1 7 2", "7 1 <!-- half --> 7 2").replace("<vcount>4", "<vcount><!-- four -->4");
    assert_eq!(corners(&file(&commented, PLAIN)), corners(&file(POLYGON, PLAIN)));
    let text = file(POLYGON, PLAIN).replace("1 1 0 8 0", "1 1 <!-- half -->0 8 0");
    assert_eq!(corners(&text), corners(&file(POLYGON, PLAIN)));
}

#[test]
fn an_accessor_says_by_name_where_the_coordinates_stand() {
    let with_parameters = |parameters: &str| {
        file(POLYGON, PLAIN).replace(
            r##"<accessor source="#list" count="4" stride="4" offset="1"/>"##,
            &format!(r##"<accessor source="#list" count="4" stride="4" offset="0">{parameters}</accessor>"##),
        )
    };
    let named = |name: &str| format!(r#"<param name="{name}" type="float"/>"#);
    let unnamed = r#"<param type="float"/>"#;
    let in_order = with_parameters(&(unnamed.to_owned() + &["X", "Y", "Z"].map(named).concat()));
    assert_eq!(corners(&in_order), corners(&file(POLYGON, PLAIN)));
    let reversed = with_parameters(&(unnamed.to_owned() + &["Z", "Y", "X"].map(named).concat()));
    let swapped = corners(&file(POLYGON, PLAIN)).into_iter().map(|point| Vector3::new(point.z, point.y, point.x));
    assert_eq!(corners(&reversed), swapped.collect::<Vec<_>>());
    let refused = ColladaError::Unsupported("accessor without X, Y and Z".to_owned());
    assert_eq!(read(&with_parameters(&["S", "T", "P"].map(named).concat())), Err(refused));
}

#[test]
fn a_primitive_with_another_count_than_it_states_is_refused() {
    let input = r##"<input semantic="VERTEX" source="#points" offset="0"/>"##;
    let refused = |primitive: &str| read(&file(primitive, PLAIN)).unwrap_err();
    let count = |element: &str, stated, found| ColladaError::Count { element: element.to_owned(), stated, found };
    let numbers = |element: &str| ColladaError::Numbers(element.to_owned());
    let triangles = format!(r#"<triangles count="2">{input}<p>0 1 2 0 2 3</p></triangles>"#);
    assert_eq!(read(&file(&triangles, PLAIN)).unwrap().len(), 2);
    assert_eq!(refused(&triangles.replace(" 0 2 3", "")), count("triangles", 2, 1));
    assert_eq!(refused(&triangles.replace(" 3<", "<")), numbers("triangles"));
    assert_eq!(
        refused(&format!(r#"<tristrips count="2">{input}<p>0 1 2 3</p></tristrips>"#)),
        count("tristrips", 2, 1)
    );
    assert_eq!(refused(&POLYGON.replace(r#"count="1""#, r#"count="2""#)), count("polylist", 2, 1));
    assert_eq!(refused(&POLYGON.replace("<vcount>4<", "<vcount>3<")), numbers("vcount"));
    assert_eq!(refused(&POLYGON.replace("7 3<", "7<")), numbers("p"));
}

#[test]
fn nodes_that_name_others_twice_end_soon() {
    let doubled = (0..30).map(|k| {
        let next = k + 1;
        format!(r##"<node id="n{k}"><instance_node url="#n{next}"/><instance_node url="#n{next}"/></node>"##)
    });
    let nodes = doubled.collect::<String>() + r#"<node id="n30"/>"#;
    let text = file(POLYGON, r##"<node><instance_node url="#n0"/></node>"##)
        .replace("<library_nodes>", &format!("<library_nodes>{nodes}"));
    assert_eq!(read(&text), Err(ColladaError::TooLarge));
}
