//! Tools that show pictures: those of variables, and those in panels.

use jde_link::message::VariableInfo;
use jde_panel::Item;
use jde_picture::{Color, Compression, PictureError};
use jde_types::{CompressedImage, Image, Value as _};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use super::{Call, OfSchema};
use crate::cli::tools::client::panel;
use crate::failure::Failure;
use crate::mcp::answer::Answer;
use crate::remote;

/// The most pictures of a panel.
const MAX_PICTURES: usize = 4;

/// A variable with pictures.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Variable {
    /// The application; may be left out if only one runs.
    application: Option<String>,
    /// The variable: "camera.image".
    variable: String,
}

pub(super) fn variable(call: &Call<'_>, arguments: Variable) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    let info = remote.variable(&arguments.variable)?;
    let sample = remote.get(&info.name)?;
    let bytes = sample.bytes.as_deref();
    let bytes = bytes.ok_or_else(|| Failure::broken(format!("`{}` has no value now", info.name)))?;
    let file = file_of(&info, bytes)?;
    let data = json!({
        "application": remote.about().name,
        "variable": info.name,
        "time_s": sample.time as f64 / 1e9,
        "age_s": sample.age as f64 / 1e9,
    });
    Ok(Answer::new(&data)?.with_picture(file))
}

/// Returns the value of a variable as a file of a picture.
fn file_of(info: &VariableInfo, bytes: &[u8]) -> Result<Vec<u8>, Failure> {
    let is_of = |name: &str| info.type_name == name;
    if is_of(&Image::describe().name)
        && let Some(image) = Image::from_bytes(bytes)
    {
        return Compression::Png.compress(&image).map_err(unusable);
    }
    if is_of(&CompressedImage::describe().name)
        && let Some(image) = CompressedImage::from_bytes(bytes)
    {
        let file = image.data.to_vec();
        // What is none is refused here, and not sent.
        jde_picture::Picture::read(&file).map_err(unusable)?;
        return Ok(file);
    }
    Err(Failure::broken(format!(
        "`{}` is {} and no picture",
        info.name, info.type_name
    )))
}

pub(super) fn panel(call: &Call<'_>, arguments: OfSchema) -> Result<Answer, Failure> {
    let remote = call.session.remote(arguments.application.as_deref())?;
    let sample = panel::newest_panel(&remote, &arguments.schema)?;
    let list = sample
        .list
        .map_err(|reason| panel::shows_nothing(&arguments.schema, &reason))?;
    let mut text = Vec::new();
    remote::panel::write(&list, &mut text)?;
    let text = jde_terminal::escape::without_styles(&String::from_utf8_lossy(&text));
    let images = list.walk().filter(|item| matches!(item, Item::Image { .. }));
    let pictures: Vec<_> = images.filter_map(|item| Some((item.id()?, png(item)?))).collect();
    let shown = &pictures[..pictures.len().min(MAX_PICTURES)];
    let data = json!({
        "application": remote.about().name,
        "schema": arguments.schema,
        "time_s": sample.time as f64 / 1e9,
        "text": text,
        "pictures": shown.iter().map(|(id, _)| id).collect::<Vec<_>>(),
        "pictures_left_out": pictures.len() - shown.len(),
    });
    let answer = Answer::new(&data)?;
    shown.iter().try_fold(answer, |answer, (_, picture)| {
        let file = picture.as_ref().map_err(|error| unusable(error.clone()))?;
        Ok(answer.with_picture(file.clone()))
    })
}

/// Returns the pixels of a widget as a PNG file; `None` if it has none. What is behind transparent pixels is white.
fn png(item: &Item) -> Option<Result<Vec<u8>, PictureError>> {
    let Item::Image {
        width,
        height,
        channels,
        pixels,
        ..
    } = item
    else {
        return None;
    };
    let size = (*width, *height);
    Some(match channels {
        1 => Compression::Png.encode(size, Color::Grey, pixels),
        4 => Compression::Png.encode(size, Color::Rgb, &over_white(pixels)),
        _ => Compression::Png.encode(size, Color::Rgb, pixels),
    })
}

fn over_white(pixels: &[u8]) -> Vec<u8> {
    let (whole, _) = pixels.as_chunks::<4>();
    let blend = |color: u8, opacity: u8| {
        let (color, opacity) = (u32::from(color), u32::from(opacity));
        ((color * opacity + 255 * (255 - opacity)) / 255) as u8
    };
    let blended = whole
        .iter()
        .flat_map(|[red, green, blue, opacity]| [red, green, blue].map(|color| blend(*color, *opacity)));
    blended.collect()
}

fn unusable(error: PictureError) -> Failure {
    Failure::broken(format!("the picture cannot be sent: {error}"))
}

#[cfg(test)]
mod tests {
    use jde_panel::Wants;

    use super::*;

    #[test]
    fn the_pixels_of_a_widget_become_a_picture() {
        let item = |channels: u8, pixels: Vec<u8>| Item::Image {
            id: "i".to_owned(),
            width: 2,
            height: 1,
            channels,
            pixels,
            wants: Wants::default(),
        };
        let rgb = |item: &Item| {
            jde_picture::Picture::read(&png(item).unwrap().unwrap())
                .unwrap()
                .rgb
        };
        assert_eq!(rgb(&item(3, vec![1, 2, 3, 4, 5, 6])), [1, 2, 3, 4, 5, 6]);
        assert_eq!(rgb(&item(1, vec![7, 8])), [7, 7, 7, 8, 8, 8]);
        let transparent = item(4, vec![1, 2, 3, 255, 9, 9, 9, 0]);
        assert_eq!(rgb(&transparent), [1, 2, 3, 255, 255, 255]);
        assert!(png(&item(3, vec![1])).unwrap().is_err());
    }
}
