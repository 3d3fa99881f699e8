//! Attributes of the source on the result: numbers are interpolated, labels are copied from where the element lies.

use super::support::{Seat, Support};
use crate::mesh::{Column, Columns};

/// Vertex columns at places on the source.
pub fn at_seats(columns: &Columns, support: &Support, seats: &[Seat]) -> Columns {
    let ids = |seat: &Seat| support.mesh.triangle(seat.triangle).map(|v| support.mesh.origin[v as usize] as usize);
    let blend = |seat: &Seat, value: &dyn Fn(usize) -> f64| -> f64 {
        ids(seat).iter().zip(seat.weights).map(|(&v, w)| w * value(v)).sum()
    };
    let nearest = |seat: &Seat| {
        let heaviest = (0..3).fold(0, |best, k| if seat.weights[k] > seat.weights[best] { k } else { best });
        ids(seat)[heaviest]
    };
    let transfer = |column: &Column| match column {
        Column::Scalar(v) => Column::Scalar(seats.iter().map(|s| blend(s, &|k| v[k])).collect()),
        Column::Vector2(v) => Column::Vector2(seats.iter().map(|s| [0, 1].map(|i| blend(s, &|k| v[k][i]))).collect()),
        Column::Vector3(v) => {
            Column::Vector3(seats.iter().map(|s| [0, 1, 2].map(|i| blend(s, &|k| v[k][i]))).collect())
        }
        Column::Label(v) => Column::Label(seats.iter().map(|s| v[nearest(s)]).collect()),
        Column::Color(v) => {
            let channel = |s: &Seat, i: usize| blend(s, &|k| f64::from(v[k][i])).round().clamp(0.0, 255.0) as u8;
            Column::Color(seats.iter().map(|s| [0, 1, 2, 3].map(|i| channel(s, i))).collect())
        }
    };
    columns.iter().map(|(name, column)| (name.clone(), transfer(column))).collect()
}
