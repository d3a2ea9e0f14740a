//! Numbers, flags and poses in elements, as libsdformat reads them.

use super::frames::Stated;
use super::pose3::Pose3;
use super::xml::Node;

/// Most letters of a number.
const MAX_NUMBER: usize = 400;

/// Returns the number with which a word begins, as `std::stod` does.
fn number(word: &str) -> Option<f64> {
    let is_part = |byte: &u8| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E');
    let length = word.bytes().take(MAX_NUMBER).take_while(is_part).count();
    let ends = (1..=length).rev();
    let number: Option<f64> = ends.filter_map(|end| word[..end].parse().ok()).next();
    number.filter(|number| number.is_finite())
}

/// Returns the first numbers of an element; `None` if there are fewer.
pub(super) fn numbers<const COUNT: usize>(node: &Node) -> Option<[f64; COUNT]> {
    let mut words = node.text().split_whitespace();
    let mut numbers = [0.0; COUNT];
    for place in &mut numbers {
        *place = number(words.next()?)?;
    }
    Some(numbers)
}

/// Returns a flag; `None` if it is none.
pub(super) fn flag(text: &str) -> Option<bool> {
    match text.trim().to_ascii_lowercase().as_str() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Returns the pose that an element contains, or what is expected there.
pub(super) fn pose(node: &Node) -> Result<Stated, (Node, String)> {
    let Some(pose) = node.child("pose") else {
        return Ok(Stated::ORIGIN);
    };
    let stated = read(&pose, pose.text()).or_else(|message| {
        // Gazebo refuses a pose that a comment divides.
        read(&pose, &pose.whole_text()).map_err(|_| (pose.clone(), message))
    });
    // `frame` is the name of the attribute before SDF 1.7, and later no attribute.
    let old = pose.attribute("frame").filter(|_| pose.is_before_relative_to());
    let relative_to = old.or(pose.attribute("relative_to")).unwrap_or_default();
    stated.map(|pose| Stated {
        pose,
        relative_to: relative_to.trim().to_owned(),
    })
}

fn read(pose: &Node, text: &str) -> Result<Pose3, String> {
    let in_degrees = match pose.attribute("degrees") {
        Some(text) => flag(text).ok_or("expected `degrees` to be true or false")?,
        None => false,
    };
    let format = pose.attribute("rotation_format").unwrap_or("euler_rpy").trim();
    let expected = match format {
        "euler_rpy" => "expected x y z roll pitch yaw",
        "quat_xyzw" if in_degrees => return Err("a quaternion is not in degrees: drop `degrees`".to_owned()),
        "quat_xyzw" => "expected x y z and the quaternion x y z w",
        _ => return Err("expected `rotation_format` to be euler_rpy or quat_xyzw".to_owned()),
    };
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    match (numbers.as_deref(), format) {
        (Some([]), _) => Ok(Pose3::ORIGIN),
        (Some(&[x, y, z, roll, pitch, yaw]), "euler_rpy") => {
            let angles = [roll, pitch, yaw];
            let angles = if in_degrees {
                angles.map(f64::to_radians)
            } else {
                angles
            };
            Ok(Pose3::euler([x, y, z], angles))
        }
        (Some(&[x, y, z, a, b, c, w]), "quat_xyzw") => Ok(Pose3::quaternion([x, y, z], [a, b, c, w])),
        _ => Err(expected.to_owned()),
    }
}
