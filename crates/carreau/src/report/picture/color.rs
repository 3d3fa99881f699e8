//! Colour spaces: sRGB as stored, linear light for mixing, OKLab (Ottosson 2020) for differences as the eye sees them.

/// An sRGB colour.
pub type Rgb = [u8; 3];

/// Linear light, red, green, blue in 0..=1.
pub(super) type Linear = [f32; 3];

/// sRGB to linear light (IEC 61966-2-1).
pub(super) fn linear(color: Rgb) -> Linear {
    color.map(|c| {
        let c = f32::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// Linear light to sRGB, clamped.
pub(super) fn encode(color: Linear) -> Rgb {
    color.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let e = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (e * 255.0).round() as u8
    })
}

/// Lightness and the green–red and blue–yellow axes.
pub(super) fn to_oklab([r, g, b]: Linear) -> [f32; 3] {
    let l = (0.412_221_46 * r + 0.536_332_55 * g + 0.051_445_995 * b).cbrt();
    let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_396_96 * b).cbrt();
    let s = (0.088_302_46 * r + 0.281_718_85 * g + 0.629_978_7 * b).cbrt();
    [
        0.210_454_26 * l + 0.793_617_8 * m - 0.004_072_047 * s,
        1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
        0.025_904_037 * l + 0.782_771_77 * m - 0.808_675_77 * s,
    ]
}

/// The inverse of [`to_oklab`]; may leave 0..=1.
pub(super) fn from_oklab([lightness, a, b]: [f32; 3]) -> Linear {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
}

/// The colour of this lightness, chroma and hue (degrees); chroma is reduced until sRGB can show it.
pub(super) fn from_lch(lightness: f32, chroma: f32, hue: f32) -> Linear {
    let (sin, cos) = hue.to_radians().sin_cos();
    let at = |chroma: f32| from_oklab([lightness, chroma * cos, chroma * sin]);
    let shown = |c: Linear| c.iter().all(|x| (-1e-4..=1.0 + 1e-4).contains(x));
    let steps = (0..=20).rev().map(|k| at(chroma * k as f32 / 20.0));
    steps.into_iter().find(|&c| shown(c)).unwrap_or([lightness.powi(3); 3])
}

/// `a` at 0, `b` at 1, in linear light.
pub(super) fn mix(a: Linear, b: Linear, share: f32) -> Linear {
    [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_is_the_inverse_of_decoding() {
        for c in 0..=255 {
            assert_eq!(encode(linear([c, 255 - c, c / 2])), [c, 255 - c, c / 2]);
        }
        assert_eq!(encode([-1.0, 2.0, f32::NAN])[..2], [0, 255]);
    }

    #[test]
    fn oklab_has_its_fixed_points_and_an_inverse() {
        let white = to_oklab([1.0; 3]);
        assert!((white[0] - 1.0).abs() < 1e-3 && white[1].abs() < 1e-3 && white[2].abs() < 1e-3, "{white:?}");
        for color in [[200, 30, 90], [1, 2, 3], [120, 250, 7]] {
            assert_eq!(encode(from_oklab(to_oklab(linear(color)))), color);
        }
    }

    #[test]
    fn chroma_is_reduced_until_it_can_be_shown() {
        for hue in 0..36 {
            let color = from_lch(0.8, 0.4, hue as f32 * 10.0);
            assert!(color.iter().all(|c| (-0.001..=1.001).contains(c)), "{color:?}");
            assert!((to_oklab(color)[0] - 0.8).abs() < 0.01);
        }
    }
}
