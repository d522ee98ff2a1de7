//! A finished figure.

use crate::axis::count;
use crate::color::INK;
use crate::error::ReportError;
use crate::font::{text_width, wrap};
use crate::panel::Drawn;
use crate::raster;
use crate::scene::{Anchor, Scene};
use crate::svg;

/// A finished picture with its number and caption.
///
/// The picture itself carries axes and legend only; the caption stands beside it, so that a document can set it in
/// its own type. [`captioned`](Self::captioned) draws it under the picture for use on its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    number: String,
    caption: String,
    scene: Scene,
}

impl Figure {
    pub(crate) fn new(number: &str, caption: String, drawn: Drawn) -> Self {
        let caption = [Some(caption), drawn.remarks()]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(" ");
        Self {
            number: number.to_owned(),
            caption,
            scene: drawn.scene,
        }
    }

    /// A picture that is no panel.
    pub(crate) fn of_scene(caption: String, scene: Scene) -> Self {
        Self {
            number: String::new(),
            caption,
            scene,
        }
    }

    /// Number in the thesis, like `3.2`; empty for a figure that has none.
    #[must_use]
    pub fn number(&self) -> &str {
        &self.number
    }

    /// The caption: whole sentences, without the number.
    #[must_use]
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// Width and height in units of 1/96 inch: the size of the SVG, and of the PNG in pixels at scale 1.
    #[must_use]
    pub fn size(&self) -> (f64, f64) {
        (self.scene.width, self.scene.height)
    }

    /// The same picture under another number; empty for none.
    #[must_use]
    pub fn with_number(mut self, number: impl Into<String>) -> Self {
        self.number = number.into();
        self
    }

    /// The same picture with another caption.
    #[must_use]
    pub fn with_caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// A taller figure with number and caption drawn below, for a file that is looked at on its own.
    #[must_use]
    pub fn captioned(&self) -> Self {
        const SIZE: f64 = 13.5;
        const MARGIN: f64 = 18.0;
        let mut scene = self.scene.clone();
        let head = self.heading();
        let indent = if head.is_empty() {
            0.0
        } else {
            text_width(&head, SIZE, true) + 6.0
        };
        let mut y = scene.height + 14.0;
        if !head.is_empty() {
            scene.bold([MARGIN, y], &head, SIZE, INK, Anchor::Start);
        }
        for (row, line) in wrap(&self.caption, SIZE, scene.width - 2.0 * MARGIN, indent)
            .iter()
            .enumerate()
        {
            let x = if row == 0 { MARGIN + indent } else { MARGIN };
            scene.text([x, y], line, SIZE, INK, Anchor::Start);
            y += 19.0;
        }
        scene.height = y;
        Self {
            scene,
            ..self.clone()
        }
    }

    /// `Figure 3.2.`, or nothing.
    pub(crate) fn heading(&self) -> String {
        if self.number.is_empty() {
            String::new()
        } else {
            format!("Figure {}.", self.number)
        }
    }

    /// The figure as SVG 1.1: text stays text, no id, script or reference, so that it can stand inside a page.
    ///
    /// Below 1 MB whatever the number of samples; the same input gives the same bytes.
    #[must_use]
    pub fn svg(&self) -> String {
        let heading = self.heading();
        let title = if heading.is_empty() {
            "Figure"
        } else {
            heading.trim_end_matches('.')
        };
        svg::write(&self.scene, title, &self.caption)
    }

    /// The figure as PNG, `scale` pixels to a unit; 2 suits a screen, 3 or more print. Needs no font on the machine.
    ///
    /// # Errors
    /// [`ReportError::Scale`] if the picture would be empty or have more than [`MAX_PIXELS`](crate::MAX_PIXELS),
    /// [`ReportError::Encode`] if the encoder fails.
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, ReportError> {
        raster::paint(&self.scene, scale)
    }
}

impl Drawn {
    /// What the picture does not show, in whole sentences.
    fn remarks(&self) -> Option<String> {
        let mut text = Vec::new();
        if self.shaded {
            text.push("Darker means more samples.".to_owned());
        }
        if self.banded {
            text.push(
                "Where samples are dense, the line is their mean and a pale band spans them all."
                    .to_owned(),
            );
        }
        match self.outside {
            0 => {}
            1 => text.push("One sample is outside the frame.".to_owned()),
            n => text.push(format!("{} samples are outside the frame.", count(n))),
        }
        match self.missing {
            0 => {}
            1 => text.push("One sample without a value is not shown.".to_owned()),
            n => text.push(format!(
                "{} samples without a value are not shown.",
                count(n)
            )),
        }
        (!text.is_empty()).then(|| text.join(" "))
    }
}
