//! The calibration of a camera: the file that ROS's `camera_calibration` writes, and the camera that a calibration
//! describes.
//!
//! A calibration holds for pictures of its size. It is not scaled, since a camera of another resolution may show another
//! part of its sensor.

use std::path::Path;

use jde_types::{CameraInfo, RegionOfInterest, Seq, Text};
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

use crate::camera::CameraModel;
use crate::distortion::Distortion;

/// The largest file, bytes. They have about one thousand.
const MAX_BYTES: u64 = 64 << 10;

impl CameraModel {
    /// Returns the camera of a calibration for pictures of some columns and rows. `rectified`: the pictures are without
    /// distortion, as those of `image_rect`.
    ///
    /// # Errors
    /// A calibration that is none, of another model, or of pictures of another size.
    pub fn calibrated(info: &CameraInfo, size: [usize; 2], rectified: bool) -> Result<Self, String> {
        let (focal, middle) = if rectified {
            ([info.p[0], info.p[5]], [info.p[2], info.p[6]])
        } else {
            ([info.k[0], info.k[4]], [info.k[2], info.k[5]])
        };
        let name = if rectified {
            "the projection (P)"
        } else {
            "the intrinsic matrix (K)"
        };
        if focal == [0.0; 2] {
            return Err(format!("{name} of the camera is 0: it is not calibrated"));
        }
        let is_finite = focal.iter().chain(&middle).all(|number| number.is_finite());
        if !is_finite || !focal.iter().all(|focal| *focal > 0.0) {
            return Err(format!(
                "{name} has focal lengths {focal:?} and the middle {middle:?}, px"
            ));
        }
        if !rectified && info.k[1] != 0.0 {
            return Err(format!(
                "{name} has a skew of {}, and pixels are rectangles here",
                info.k[1]
            ));
        }
        let binning = [info.binning_x, info.binning_y].map(|binning| binning.max(1));
        let shown = shown(info);
        let expected = [shown.width / binning[0], shown.height / binning[1]];
        if size != expected.map(|pixels| pixels as usize) {
            let [[width, height], [columns, rows]] = [size, expected.map(|pixels| pixels as usize)];
            return Err(format!(
                "the calibration is of pictures of {columns} x {rows} pixels, and these have {width} x {height}: calibrate \
                 the camera with this size, or let it take pictures of that size"
            ));
        }
        let distortion = if rectified {
            Distortion::None
        } else {
            Distortion::named(info.distortion_model.as_str(), info.d.as_slice())?
        };
        let offset = [shown.x_offset, shown.y_offset];
        Ok(Self {
            focal: [0, 1].map(|axis| focal[axis] / f64::from(binning[axis])),
            // In a calibration the middle of the first pixel is at 0, 0.
            middle: [0, 1]
                .map(|axis| (middle[axis] + 0.5 - f64::from(offset[axis])) / f64::from(binning[axis])),
            distortion,
        })
    }
}

/// Returns the part of the camera's pixels that pictures show.
fn shown(info: &CameraInfo) -> RegionOfInterest {
    match info.roi {
        RegionOfInterest { width: 0, .. } | RegionOfInterest { height: 0, .. } => RegionOfInterest {
            width: info.width,
            height: info.height,
            ..RegionOfInterest::default()
        },
        part => part,
    }
}

/// Reads a calibration file: the YAML that ROS's `camera_calibration` writes and `camera_info_manager` reads, or that of
/// OpenCV with the same keys.
///
/// # Errors
/// It cannot be read, or is no calibration: the file, the line and what is expected.
pub fn read_calibration(path: &Path) -> Result<CameraInfo, String> {
    let text = jde_files::read_text(path, MAX_BYTES)
        .map_err(|error| format!("cannot read the calibration {}: {error}", path.display()))?;
    parse_calibration(&text).map_err(|(line, message)| format!("{}:{line}: {message}", path.display()))
}

/// A line, and what is wrong there.
type Fault = (usize, String);

/// Reads the text of a calibration file; see [`read_calibration`].
///
/// # Errors
/// It is no calibration: the line, and what is expected.
pub fn parse_calibration(text: &str) -> Result<CameraInfo, Fault> {
    // OpenCV writes a directive that YAML does not have. Its line stays, so that lines are counted right.
    let text = match text.strip_prefix("%YAML:") {
        Some(rest) => &rest[rest.find('\n').unwrap_or(rest.len())..],
        None => text,
    };
    let documents = MarkedYaml::load_from_str(text)
        .map_err(|error| (error.marker().line(), format!("invalid YAML: {}", error.info())))?;
    let Some(root) = documents.first().filter(|root| root.data.is_mapping()) else {
        return Err((
            1,
            "this is no calibration: expected the YAML of a camera, with `camera_matrix`".to_owned(),
        ));
    };
    let size = |key| {
        let node = required(root, key)?;
        let pixels = number(node).filter(|pixels| pixels.fract() == 0.0 && (1.0..=65_536.0).contains(pixels));
        pixels
            .map(|pixels| pixels as u32)
            .ok_or_else(|| (line(node), format!("`{key}` is no number of pixels")))
    };
    let (width, height) = (size("image_width")?, size("image_height")?);
    let k = matrix(required(root, "camera_matrix")?, "camera_matrix")?;
    let d = match find(root, "distortion_coefficients") {
        Some(node) => numbers(node, "distortion_coefficients")?,
        None => Vec::new(),
    };
    let model = match find(root, "distortion_model").map(|node| (node, node.data.as_str())) {
        Some((_, Some(name))) if name.len() <= 28 => name.to_owned(),
        Some((node, _)) => return Err((line(node), "`distortion_model` is no name of a model".to_owned())),
        None if d.len() > 5 => "rational_polynomial".to_owned(),
        None => "plumb_bob".to_owned(),
    };
    let at = find(root, "distortion_coefficients").map_or(1, line);
    Distortion::named(&model, &d).map_err(|message| (at, message))?;
    let unity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let r =
        find(root, "rectification_matrix").map_or(Ok(unity), |node| matrix(node, "rectification_matrix"))?;
    let p =
        find(root, "projection_matrix").map_or(Ok([0.0; 12]), |node| matrix(node, "projection_matrix"))?;
    let mut coefficients = Seq::new();
    // The model has at most as many.
    coefficients
        .extend_from_slice(&d)
        .map_err(|_| (at, "too many distortion coefficients".to_owned()))?;
    let info = CameraInfo {
        width,
        height,
        distortion_model: Text::truncated(&model),
        d: coefficients,
        k,
        r,
        p,
        ..CameraInfo::default()
    };
    CameraModel::calibrated(&info, [width, height].map(|pixels| pixels as usize), false)
        .map_err(|message| (find(root, "camera_matrix").map_or(1, line), message))?;
    Ok(info)
}

fn matrix<const N: usize>(node: &MarkedYaml<'_>, key: &str) -> Result<[f64; N], Fault> {
    let numbers = numbers(node, key)?;
    let count = numbers.len();
    numbers
        .try_into()
        .map_err(|_| (line(node), format!("`{key}` has {count} numbers: expected {N}")))
}

/// Reads `{ rows: .., cols: .., data: [..] }`.
fn numbers(node: &MarkedYaml<'_>, key: &str) -> Result<Vec<f64>, Fault> {
    let data =
        find(node, "data").and_then(|data| untagged(data).data.as_sequence().map(|items| (data, items)));
    let Some((data, items)) = data else {
        return Err((line(node), format!("`{key}` has no list `data` of numbers")));
    };
    let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
    numbers.ok_or_else(|| {
        (
            line(data),
            format!("`data` of `{key}` has something that is no finite number"),
        )
    })
}

fn number(node: &MarkedYaml<'_>) -> Option<f64> {
    let value = match &node.data {
        YamlData::Value(Scalar::Integer(value)) => *value as f64,
        YamlData::Value(Scalar::FloatingPoint(value)) => value.into_inner(),
        _ => return None,
    };
    value.is_finite().then_some(value)
}

fn required<'n>(root: &'n MarkedYaml<'n>, key: &str) -> Result<&'n MarkedYaml<'n>, Fault> {
    find(root, key).ok_or_else(|| {
        (
            1,
            format!("this is no calibration of a camera: it has no `{key}`"),
        )
    })
}

fn find<'n>(node: &'n MarkedYaml<'n>, key: &str) -> Option<&'n MarkedYaml<'n>> {
    let entries = untagged(node).data.as_mapping()?;
    entries
        .iter()
        .find(|(name, _)| name.data.as_str() == Some(key))
        .map(|(_, value)| value)
}

/// Returns what a tag such as `!!opencv-matrix` stands before.
fn untagged<'n>(node: &'n MarkedYaml<'n>) -> &'n MarkedYaml<'n> {
    match &node.data {
        YamlData::Tagged(_, inner) => inner,
        _ => node,
    }
}

fn line(node: &MarkedYaml<'_>) -> usize {
    node.span.start.line()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As ROS's `camera_calibration` writes it.
    const FILE: &str = "image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [600., 0., 319.5, 0., 610., 239.5, 0., 0., 1.]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.09, 0.0007, -0.0013, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [580., 0., 318., 0., 0., 590., 241., 0., 0., 0., 1., 0.]
";

    #[test]
    fn a_file_of_ros_gives_the_raw_and_the_rectified_camera() {
        let info = parse_calibration(FILE).unwrap();
        assert_eq!(
            (info.width, info.height, info.distortion_model.as_str()),
            (640, 480, "plumb_bob")
        );
        let raw = CameraModel::calibrated(&info, [640, 480], false).unwrap();
        assert_eq!((raw.focal(), raw.middle()), ([600.0, 610.0], [320.0, 240.0]));
        let corner = raw.pixel([0.4, -0.3, 1.0]).unwrap();
        let ray = raw.ray(corner).unwrap();
        assert!((ray[0] - 0.4).hypot(ray[1] + 0.3) < 1e-9);
        let rectified = CameraModel::calibrated(&info, [640, 480], true).unwrap();
        assert_eq!(rectified.ray([318.5 + 58.0, 241.5]), Some([0.1, 0.0, 1.0]));
    }

    #[test]
    fn a_file_of_opencv_is_read_too() {
        let text = FILE
            .replace("camera_matrix:\n", "camera_matrix: !!opencv-matrix\n")
            .replace("distortion_model: plumb_bob\n", "");
        let info = parse_calibration(&format!("%YAML:1.0\n---\n{text}")).unwrap();
        assert_eq!(info.k, parse_calibration(FILE).unwrap().k);
    }

    #[test]
    fn pictures_of_another_size_or_of_a_part_are_no_surprise() {
        let mut info = parse_calibration(FILE).unwrap();
        let message = CameraModel::calibrated(&info, [320, 240], false).unwrap_err();
        assert!(
            message.contains("640 x 480 pixels, and these have 320 x 240"),
            "{message}"
        );
        (info.binning_x, info.binning_y) = (2, 2);
        let binned = CameraModel::calibrated(&info, [320, 240], false).unwrap();
        assert_eq!(
            (binned.focal(), binned.middle()),
            ([300.0, 305.0], [160.0, 120.0])
        );
        info.roi = RegionOfInterest {
            x_offset: 100,
            y_offset: 40,
            width: 400,
            height: 200,
            ..RegionOfInterest::default()
        };
        let part = CameraModel::calibrated(&info, [200, 100], false).unwrap();
        assert_eq!(part.middle(), [110.0, 100.0]);
    }

    #[test]
    fn what_is_no_calibration_is_refused_with_its_line() {
        let wrong = |from: &str, to: &str| parse_calibration(&FILE.replace(from, to)).unwrap_err();
        let (line, message) = wrong("data: [600., 0., 319.5", "data: [0., 0., 319.5");
        assert!(
            message.contains("focal lengths [0.0, 610.0]") && line == 5,
            "{line}: {message}"
        );
        let (line, message) = wrong("[-0.28, 0.09,", "[-0.28, many,");
        assert_eq!(
            (line, message.contains("no finite number")),
            (12, true),
            "{message}"
        );
        let (line, message) = wrong("plumb_bob", "fov");
        assert!(
            message.contains("`fov` is unknown") && line > 8,
            "{line}: {message}"
        );
        let (_, message) = parse_calibration("image: map.pgm\nresolution: 0.05").unwrap_err();
        assert!(message.contains("it has no `image_width`"), "{message}");
        assert!(parse_calibration("a: [").unwrap_err().1.contains("invalid YAML"));
        assert!(parse_calibration("").unwrap_err().1.contains("no calibration"));
        let uncalibrated = CameraInfo {
            width: 2,
            height: 2,
            ..CameraInfo::default()
        };
        let message = CameraModel::calibrated(&uncalibrated, [2, 2], false).unwrap_err();
        assert!(message.contains("it is not calibrated"), "{message}");
    }
}
