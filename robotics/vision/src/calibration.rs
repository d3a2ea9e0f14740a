//! The calibration of a camera: the file that ROS's `camera_calibration` writes, and the camera that a calibration
//! describes.
//!
//! A calibration holds for pictures of its size. It is not scaled, since a camera of another resolution may show another
//! part of its sensor.

use std::ops::Range;
use std::path::Path;

use jde_document::{Fault, FaultReport, Faults};
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
/// It cannot be read, or is no calibration.
pub fn read_calibration(path: &Path) -> Result<CameraInfo, Faults> {
    let text = jde_files::read_text(path, MAX_BYTES)
        .map_err(|error| Fault::of_file(path, format!("cannot read the calibration: {error}")))?;
    parse_calibration(path, &text)
}

/// Reads the text of a calibration file; see [`read_calibration`].
///
/// # Errors
/// It is no calibration.
pub fn parse_calibration(path: &Path, text: &str) -> Result<CameraInfo, Faults> {
    // OpenCV writes a directive that YAML does not have. Its line stays, so that lines are counted right.
    let text = match text.strip_prefix("%YAML:") {
        Some(rest) => &rest[rest.find('\n').unwrap_or(rest.len())..],
        None => text,
    };
    parse(text).map_err(|(place, message)| {
        let mut report = FaultReport::new(path, text);
        match place {
            Some(place) => report.fault(&report.in_bytes(&place), message),
            None => report.file_fault(message),
        };
        report.into_faults()
    })
}

/// Where something is wrong, in characters from the start of the text, or in the text as a whole; and what.
type Wrong = (Option<Range<usize>>, String);

fn parse(text: &str) -> Result<CameraInfo, Wrong> {
    let documents = MarkedYaml::load_from_str(text).map_err(|error| {
        let at = error.marker().index();
        (Some(at..at), format!("this is not YAML: {}", error.info()))
    })?;
    let Some(root) = documents.first().filter(|root| root.data.is_mapping()) else {
        return Err((
            None,
            "this is not a calibration: expected the YAML of a camera, with `camera_matrix`".to_owned(),
        ));
    };
    let size = |key| {
        let node = required(root, key)?;
        let pixels = number(node).filter(|pixels| pixels.fract() == 0.0 && (1.0..=65_536.0).contains(pixels));
        pixels
            .map(|pixels| pixels as u32)
            .ok_or_else(|| (place(node), format!("`{key}` is not a number of pixels")))
    };
    let (width, height) = (size("image_width")?, size("image_height")?);
    let k = matrix(required(root, "camera_matrix")?, "camera_matrix")?;
    let d = match find(root, "distortion_coefficients") {
        Some(node) => numbers(node, "distortion_coefficients")?,
        None => Vec::new(),
    };
    let model = match find(root, "distortion_model").map(|node| (node, node.data.as_str())) {
        Some((_, Some(name))) if name.len() <= 28 => name.to_owned(),
        Some((node, _)) => return Err((place(node), "`distortion_model` is no name of a model".to_owned())),
        None if d.len() > 5 => "rational_polynomial".to_owned(),
        None => "plumb_bob".to_owned(),
    };
    let at = find(root, "distortion_coefficients").and_then(place);
    Distortion::named(&model, &d).map_err(|message| (at.clone(), message))?;
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
        .map_err(|message| (find(root, "camera_matrix").and_then(place), message))?;
    Ok(info)
}

fn matrix<const N: usize>(node: &MarkedYaml<'_>, key: &str) -> Result<[f64; N], Wrong> {
    let numbers = numbers(node, key)?;
    let count = numbers.len();
    numbers
        .try_into()
        .map_err(|_| (place(node), format!("`{key}` has {count} numbers: expected {N}")))
}

/// Reads `{ rows: .., cols: .., data: [..] }`.
fn numbers(node: &MarkedYaml<'_>, key: &str) -> Result<Vec<f64>, Wrong> {
    let data =
        find(node, "data").and_then(|data| untagged(data).data.as_sequence().map(|items| (data, items)));
    let Some((data, items)) = data else {
        return Err((place(node), format!("`{key}` has no list `data` of numbers")));
    };
    let numbers: Option<Vec<f64>> = items.iter().map(number).collect();
    numbers.ok_or_else(|| {
        (
            place(data),
            format!("`data` of `{key}` has something that is not a finite number"),
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

fn required<'n>(root: &'n MarkedYaml<'n>, key: &str) -> Result<&'n MarkedYaml<'n>, Wrong> {
    find(root, key).ok_or_else(|| {
        (
            None,
            format!("this is not a calibration of a camera: it has no `{key}`"),
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

fn place(node: &MarkedYaml<'_>) -> Option<Range<usize>> {
    Some(node.span.start.index()..node.span.end.index())
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
        let info = parse(FILE).unwrap();
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
        let text = format!("%YAML:1.0\n---\n{text}");
        let info = parse_calibration(Path::new("c.yaml"), &text).unwrap();
        assert_eq!(info.k, parse(FILE).unwrap().k);
    }

    #[test]
    fn pictures_of_another_size_or_of_a_part_are_no_surprise() {
        let mut info = parse(FILE).unwrap();
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
    fn what_is_no_calibration_is_refused_at_its_place() {
        for (from, to, expected) in [
            (
                "data: [600., 0., 319.5",
                "data: [0., 0., 319.5",
                "c.yaml:5:3: the intrinsic matrix (K) has focal lengths [0.0, 610.0]",
            ),
            (
                "[-0.28, 0.09,",
                "[-0.28, many,",
                "c.yaml:12:9: `data` of `distortion_coefficients` has something that is not a finite number",
            ),
            ("plumb_bob", "fov", "`fov` is unknown"),
            (
                "image_width",
                "width",
                "c.yaml: this is not a calibration of a camera: it has no `image_width`",
            ),
            ("image_width: 640", "a: [", "this is not YAML"),
            (FILE, "", "c.yaml: this is not a calibration"),
        ] {
            let error = parse_calibration(Path::new("c.yaml"), &FILE.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(expected), "{to}: {error}");
        }
        let uncalibrated = CameraInfo {
            width: 2,
            height: 2,
            ..CameraInfo::default()
        };
        let message = CameraModel::calibrated(&uncalibrated, [2, 2], false).unwrap_err();
        assert!(message.contains("it is not calibrated"), "{message}");
    }
}
