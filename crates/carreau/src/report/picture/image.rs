//! The finished picture.

use super::color::{Linear, Rgb, encode};
use crate::error::{Error, Result};
use rayon::prelude::*;

/// An image of sRGB pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    size: [u32; 2],
    pixels: Vec<Rgb>,
}

impl Image {
    /// Pixels row by row from the top left; there are `width · height`.
    pub(super) fn new(size: [u32; 2], pixels: Vec<Rgb>) -> Self {
        debug_assert_eq!(pixels.len(), size[0] as usize * size[1] as usize);
        Image { size, pixels }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.size[0]
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.size[1]
    }

    /// The pixels, row by row from the top left.
    pub fn pixels(&self) -> &[Rgb] {
        &self.pixels
    }

    /// The pixel in a column and a row, both counted from 0 at the top left; `None` outside.
    pub fn pixel(&self, column: u32, row: u32) -> Option<Rgb> {
        let inside = column < self.width() && row < self.height();
        inside.then(|| self.pixels[row as usize * self.width() as usize + column as usize])
    }

    /// This image seen through another one of the same size, which covers it by `share` (0 to 1).
    pub fn behind(&self, veil: &Image, share: f64) -> Image {
        let mix = |(&below, &above): (&Rgb, &Rgb)| -> Rgb {
            std::array::from_fn(|k| {
                (share * f64::from(above[k]) + (1.0 - share) * f64::from(below[k])).round().clamp(0.0, 255.0) as u8
            })
        };
        Image::new(self.size, self.pixels.iter().zip(&veil.pixels).map(mix).collect())
    }

    /// Images side by side, top-aligned; gaps below shorter ones get the colour `fill`.
    pub fn beside(images: &[Image], fill: Rgb) -> Image {
        let width = images.iter().map(Image::width).sum();
        let height = images.iter().map(Image::height).max().unwrap_or(0);
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for row in 0..height {
            for image in images {
                pixels.extend((0..image.width()).map(|column| image.pixel(column, row).unwrap_or(fill)));
            }
        }
        Image::new([width, height], pixels)
    }

    /// The image as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`Error::Options`] for an image without pixels, which PNG cannot hold.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let failed = |e: png::EncodingError| Error::Options(format!("the image cannot be written as PNG: {e}"));
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

/// The pixels of whole rows of samples, `side` × `side` samples each.
pub(super) fn average(samples: &[Linear], width: usize, side: usize) -> Vec<Rgb> {
    let share = 1.0 / (side * side) as f32;
    samples
        .par_chunks(width * side)
        .flat_map_iter(|rows| {
            (0..width / side).map(move |column| {
                let mut sum = [0.0f32; 3];
                for row in rows.chunks(width) {
                    for sample in &row[column * side..(column + 1) * side] {
                        (0..3).for_each(|k| sum[k] += sample[k]);
                    }
                }
                encode(sum.map(|s| s * share))
            })
        })
        .collect()
}
