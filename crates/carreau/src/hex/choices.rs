//! Choices among a few.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Where a layer of hexes is put.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Padding {
    /// No layer.
    None,
    /// On the wall: every hex is cut in three across its axis.
    Sides,
    /// On the whole boundary, ends included: no hex has two boundary faces.
    #[default]
    All,
}

/// How much the skeleton is cleaned up before it is meshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The graph as given: one segment, one ring of hexes.
    Base,
    /// Stubs are dropped, and branches resampled.
    #[default]
    Full,
}

/// The order of the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "OrderNumber", into = "u8")]
pub enum Order {
    /// Straight edges: 8 nodes per cell.
    #[default]
    First,
    /// Curved edges with a node in the middle: 27 nodes per cell, or 20 in formats that hold no more.
    Second,
}

/// The order as a number, or as a command line has it.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum OrderNumber {
    Number(u8),
    Word(String),
}

impl TryFrom<OrderNumber> for Order {
    type Error = Error;

    fn try_from(order: OrderNumber) -> Result<Order> {
        let word = match order {
            OrderNumber::Number(number) => number.to_string(),
            OrderNumber::Word(word) => word,
        };
        match word.as_str() {
            "1" => Ok(Order::First),
            "2" => Ok(Order::Second),
            _ => Err(Error::Options(format!("the order of the cells is {word}, it must be 1 or 2"))),
        }
    }
}

impl From<Order> for u8 {
    fn from(order: Order) -> u8 {
        match order {
            Order::First => 1,
            Order::Second => 2,
        }
    }
}
