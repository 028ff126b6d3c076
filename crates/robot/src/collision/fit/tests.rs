use super::capsule::around_points;
use super::primitive::{MOST_PER_BOX, around_box, around_cylinder};
use super::split::around_triangles;
use super::*;
use crate::UrdfOptions;

/// Numbers of −1 … 1 from a fixed sequence.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self, size: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next()).component_mul(size)
    }
}

fn contains(capsule: &FittedCapsule, point: &Vector3<f64>) -> bool {
    Segment::point(*point).to_segment(&capsule.core).distance <= capsule.radius
}

#[test]
fn a_capsule_contains_its_points_and_is_not_much_larger() {
    let mut numbers = Numbers(1);
    for case in 0..200 {
        let size = Vector3::new(1.0, 0.05 + numbers.next().abs(), 0.05 + numbers.next().abs());
        let turn = nalgebra::Rotation3::new(numbers.point(&Vector3::repeat(3.0)));
        let away = numbers.point(&Vector3::repeat(2.0));
        let points: Vec<_> = (0..60).map(|_| turn * numbers.point(&size) + away).collect();
        let capsule = around_points(&points);
        assert!(points.iter().all(|point| contains(&capsule, point)), "case {case}");
        // A capsule along the longest edge of the box from which the points are.
        let simple = around_cylinder(size.y.hypot(size.z), 2.0 * size.x);
        assert!(capsule.volume() < 1.05 * simple.volume(), "case {case}: {} of {}", capsule.volume(), simple.volume());
    }
}

#[test]
fn one_point_and_points_in_a_line_or_plane_are_contained() {
    let point = Vector3::new(0.3, -0.2, 5.0);
    for points in [vec![point], vec![point; 4], vec![point, -point], vec![point, -point, Vector3::x()]] {
        let capsule = around_points(&points);
        assert!(points.iter().all(|point| contains(&capsule, point)), "{points:?}");
        assert!(capsule.radius > 0.0 && capsule.radius.is_finite(), "{capsule:?}");
    }
}

#[test]
fn cylinders_and_boxes_are_contained() {
    let mut numbers = Numbers(2);
    for _ in 0..200 {
        let [radius, length] = [0.01 + numbers.next().abs(), 0.01 + 2.0 * numbers.next().abs()];
        let capsule = around_cylinder(radius, length);
        for k in 0..32 {
            let (sin, cos) = (f64::from(k) * 0.2).sin_cos();
            let rim = Vector3::new(radius * cos, radius * sin, 0.5 * length) * (1.0 - 1e-12);
            assert!(contains(&capsule, &rim) && contains(&capsule, &-rim), "{radius}, {length}");
        }
        let size = Vector3::new(0.01 + numbers.next().abs(), 0.01 + numbers.next().abs(), 0.01 + numbers.next().abs());
        let capsules = around_box(&size);
        assert!(capsules.len() <= MOST_PER_BOX);
        for k in 0..500 {
            // Points of the surface: one coordinate is that of a face.
            let mut point = numbers.point(&(0.5 * size));
            let axis = k % 3;
            point[axis] = 0.5 * size[axis].copysign(point[axis]);
            let inside = point * (1.0 - 1e-12);
            assert!(capsules.iter().any(|capsule| contains(capsule, &inside)), "{size:?}: {point:?}");
        }
    }
}

/// Returns the triangles of a bent tube: along x, then along y.
fn elbow() -> Vec<Triangle> {
    let ring = |middle: Vector3<f64>, side: Vector3<f64>| {
        (0..12).map(move |k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
            middle + (side * cos + Vector3::z() * sin) * 0.05
        })
    };
    let rings: Vec<Vec<Vector3<f64>>> = (0..=10)
        .map(|k| ring(Vector3::x() * 0.05 * f64::from(k), Vector3::y()).collect())
        .chain((0..=10).map(|k| ring(Vector3::new(0.5, 0.05 * f64::from(k), 0.0), Vector3::x()).collect()))
        .collect();
    let mut triangles = Vec::new();
    for pair in rings.windows(2) {
        for k in 0..12 {
            let next = (k + 1) % 12;
            triangles.push([pair[0][k], pair[0][next], pair[1][k]]);
            triangles.push([pair[1][k], pair[1][next], pair[0][next]]);
        }
    }
    triangles
}

#[test]
fn a_bent_mesh_gets_several_capsules_and_each_triangle_is_in_one() {
    let triangles = elbow();
    let (one, several) = (around_triangles(&triangles, 1), around_triangles(&triangles, MOST_PER_MESH));
    assert_eq!(one.len(), 1);
    assert!((2..=MOST_PER_MESH).contains(&several.len()), "{}", several.len());
    let volume = |capsules: &[FittedCapsule]| capsules.iter().map(FittedCapsule::volume).sum::<f64>();
    assert!(volume(&several) < 0.5 * volume(&one), "{} of {}", volume(&several), volume(&one));
    for triangle in &triangles {
        let is_inside = |capsule: &FittedCapsule| triangle.iter().all(|corner| contains(capsule, corner));
        assert!(several.iter().any(is_inside), "{triangle:?}");
    }
}

const TEXT: &str = r#"
  <robot name="arm">
    <link name="floor"><collision><geometry><box size="1 1 0.1"/></geometry></collision></link>
    <link name="base"/>
    <link name="upper">
      <collision><origin xyz="0.2 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision>
    </link>
    <link name="hand"><collision><geometry><sphere radius="0.04"/></geometry></collision></link>
    <link name="finger"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
    <link name="camera"><visual><geometry><sphere radius="0.01"/></geometry></visual></link>
    <joint name="mount" type="fixed"><parent link="floor"/><child link="base"/><origin xyz="0 0 0.5"/></joint>
    <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
      <limit lower="-2" upper="2" velocity="1"/></joint>
    <joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="0.4 0 0"/></joint>
    <joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/><axis xyz="0 1 0"/>
      <limit lower="0" upper="0.04" velocity="1"/></joint>
    <joint name="eye" type="fixed"><parent link="hand"/><child link="camera"/></joint>
  </robot>"#;

#[test]
fn bodies_of_links_beside_the_chain_move_with_it_if_they_are_fixed() {
    let options = UrdfOptions { base: Some("base"), tip: Some("upper"), ..UrdfOptions::default() };
    let robot = RobotModel::from_urdf(TEXT, &options).unwrap();
    let fitted = robot.fitted_shapes(TEXT, None, &[]).unwrap();
    assert_eq!(fitted.uncovered, ["finger", "camera"]);
    let links: Vec<_> =
        fitted.capsules.iter().map(|capsule| robot.links()[capsule.link.index()].name.as_str()).collect();
    assert_eq!(links, ["base", "base", "base", "base", "upper", "upper"]);
    // The floor is half a metre below the base; the hand is 0.4 m before the shoulder.
    assert!((fitted.capsules[0].core.from.z + 0.5).abs() < 1e-12);
    let hand = fitted.capsules[5];
    assert!((hand.core.from - Vector3::new(0.4, 0.0, 0.0)).norm() < 1e-12 && hand.radius == 0.04, "{hand:?}");
    let cylinder = fitted.capsules[4];
    assert!(cylinder.core.ends().iter().all(|end| end.y.abs() < 1e-12 && end.z.abs() < 1e-12), "{cylinder:?}");
}

#[test]
fn a_capsule_of_the_text_stays_as_it_is() {
    let text = TEXT.replace(r#"<sphere radius="0.04"/>"#, r#"<capsule radius="0.04" length="0.3"/>"#);
    let robot = RobotModel::from_urdf(&text, &UrdfOptions { tip: Some("hand"), ..UrdfOptions::default() }).unwrap();
    let hand = *robot.fitted_shapes(&text, None, &[]).unwrap().capsules.last().unwrap();
    assert_eq!((hand.core.from.z, hand.core.to.z, hand.radius), (-0.15, 0.15, 0.04));
}

#[test]
fn what_cannot_be_fitted_is_refused_with_its_link() {
    let refused = |form: &str| {
        let text = TEXT.replace(r#"<sphere radius="0.04"/>"#, form);
        let robot =
            RobotModel::from_urdf(&text, &UrdfOptions { tip: Some("upper"), ..UrdfOptions::default() }).unwrap();
        robot.fitted_shapes(&text, None, &[]).unwrap_err().to_string()
    };
    assert!(refused(r#"<sphere radius="0"/>"#).contains("link `hand`: `radius` must be a positive number"));
    assert!(refused(r#"<box size="1 2"/>"#).contains("not three numbers"));
    assert!(refused(r#"<capsule radius="0.1" length="-1"/>"#).contains("`length` must be a positive number"));
    assert!(refused("<torus/>").contains("<torus> is none of"));
    let mesh = r#"<mesh filename="package://x/a.stl"/>"#;
    assert!(refused(mesh).contains("revprio robots fit"));
    // A link whose shapes are stated needs no mesh.
    let text = TEXT.replace(r#"<sphere radius="0.04"/>"#, mesh);
    let robot = RobotModel::from_urdf(&text, &UrdfOptions { tip: Some("upper"), ..UrdfOptions::default() }).unwrap();
    assert_eq!(robot.fitted_shapes(&text, None, &["hand".to_owned()]).unwrap().capsules.len(), 5);
    let bare = "<robot name='bare'><link name='a'/><link name='b'/><joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>";
    let robot = RobotModel::from_urdf(bare, &UrdfOptions::default()).unwrap();
    assert!(matches!(robot.fitted_shapes(bare, None, &[]), Err(FitError::NoBodies)));
}

#[test]
fn a_mesh_is_found_beside_the_file_and_in_packages_and_contained() {
    let directory = std::env::temp_dir().join(format!("revprio-fit-{}", std::process::id()));
    let meshes = directory.join("arm_description/meshes");
    std::fs::create_dir_all(&meshes).unwrap();
    let corners = |triangle: &Triangle| triangle.map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
    let facets =
        elbow().into_iter().map(|t| format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", corners(&t)));
    std::fs::write(meshes.join("elbow.stl"), format!("solid elbow\n{}endsolid elbow\n", facets.collect::<String>()))
        .unwrap();
    std::fs::write(meshes.join("broken.stl"), "solid nothing\nendsolid nothing\n").unwrap();
    let files = MeshDirectory::of_urdf(&directory.join("arm_description/urdf/arm.urdf"));
    let one = Vector3::repeat(1.0);
    for name in ["package://arm_description/meshes/elbow.stl", "../meshes/elbow.stl"] {
        let triangles = files.read(name, &one);
        // The directory `urdf` does not exist, so a name beside the file leads nowhere.
        assert_eq!(triangles.is_ok(), name.starts_with("package"), "{name}");
    }
    let triangles = files.read("package://arm_description/meshes/elbow.stl", &(2.0 * one)).unwrap();
    assert_eq!(triangles.len(), elbow().len());
    assert!((triangles[0][0] - 2.0 * elbow()[0][0]).norm() < 1e-6);
    assert!(matches!(
        files.read("package://arm_description/meshes/broken.stl", &one),
        Err(MeshError::Triangles { .. } | MeshError::Read { .. })
    ));
    std::fs::write(meshes.join("scene.dae"), "<COLLADA/>").unwrap();
    std::fs::write(meshes.join("scene.glb"), "").unwrap();
    let read = |name: &str| files.read(&format!("package://arm_description/meshes/{name}"), &one);
    assert!(matches!(read("scene.dae"), Err(MeshError::Triangles { .. })));
    assert!(matches!(read("scene.glb"), Err(MeshError::Format { .. })));
    assert!(matches!(files.read("package://arm_description/meshes/none.stl", &one), Err(MeshError::NotFound { .. })));
    std::fs::remove_dir_all(&directory).unwrap();
}
