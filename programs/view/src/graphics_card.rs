//! Errors of the graphics card: why none can draw, and its loss while windows are open. The windows then
//! close, with the reason, and never panic.

use std::sync::{Arc, OnceLock};

use eframe::egui;
use eframe::egui_wgpu::{RenderState, WgpuError};

use crate::Error;

/// Why the graphics card was lost; empty while it draws.
#[derive(Clone, Debug, Default)]
pub(crate) struct DeviceLoss(Arc<OnceLock<String>>);

impl DeviceLoss {
    /// Registers for the loss and the errors of a card.
    pub(crate) fn watch(&self, ctx: &egui::Context, card: &RenderState) {
        let (lost, again) = (self.clone(), ctx.clone());
        card.device.set_device_lost_callback(move |reason, message| {
            // `Destroyed` occurs when any window closes.
            if reason != wgpu::DeviceLostReason::Destroyed {
                lost.note(&again, message);
            }
        });
        let (lost, again) = (self.clone(), ctx.clone());
        card.device
            .on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                lost.note(&again, error.to_string());
            }));
    }

    /// The reason, if the card was lost.
    pub(crate) fn reason(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }

    /// Keeps the first reason; later ones follow from it.
    fn note(&self, ctx: &egui::Context, message: String) {
        if self.0.set(message).is_ok() {
            ctx.request_repaint();
        }
    }
}

/// Classifies why windows cannot be shown.
pub(crate) fn refused(error: &eframe::Error) -> Error {
    match error {
        eframe::Error::Wgpu(
            WgpuError::RequestAdapterError(_)
            | WgpuError::CustomNativeAdapterSelectionError(_)
            | WgpuError::NoSurfaceFormatsAvailable
            | WgpuError::RequestDeviceError(_)
            | WgpuError::CreateSurfaceError(_),
        ) => Error::NoCard(error.to_string()),
        error => Error::Window(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui_wgpu::RendererOptions;
    use egui_kittest::wgpu::{create_render_state, default_wgpu_setup};

    use super::*;

    #[test]
    fn the_first_error_of_the_card_is_kept_as_the_reason() {
        let card = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
        let (ctx, lost) = (egui::Context::default(), DeviceLoss::default());
        lost.watch(&ctx, &card);
        assert_eq!(lost.reason(), None);
        let limit = card.device.limits().max_texture_dimension_2d;
        let texture = |width| {
            card.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("far too wide"),
                size: wgpu::Extent3d {
                    width,
                    ..wgpu::Extent3d::default()
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        texture(2 * limit);
        let reason = lost.reason().expect("the texture was refused").to_owned();
        assert!(reason.contains("far too wide"), "{reason}");
        texture(3 * limit);
        assert_eq!(lost.reason(), Some(reason.as_str()), "the first reason is kept");
    }
}
