//! Words for messages.

/// A number with its noun: `counted(1, "edge", "edges")` is "1 edge".
///
/// ```
/// use carreau::words::counted;
/// assert_eq!(counted(1, "vertex", "vertices"), "1 vertex");
/// assert_eq!(counted(0, "vertex", "vertices"), "0 vertices");
/// ```
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Digits that a person is shown of the extent of a model.
const DIGITS: i32 = 10;

/// A number for a person: rounded relative to an extent, so that noise of the arithmetic is not shown.
///
/// ```
/// use carreau::words::rounded;
/// assert_eq!(rounded(8.9e-16, 1.0), "0");
/// assert_eq!(rounded(0.1 + 0.2, 1.0), "0.3");
/// assert_eq!(rounded(1234.5, 2000.0), "1234.5");
/// ```
pub fn rounded(x: f64, extent: f64) -> String {
    if !(extent > 0.0 && extent.is_finite() && x.is_finite()) {
        return format!("{x}");
    }
    let decimals = DIGITS - 1 - extent.log10().floor() as i32;
    let Ok(places) = usize::try_from(decimals) else {
        // A large extent: its digits are all before the point.
        return format!("{}", (x / 10f64.powi(-decimals)).round() * 10f64.powi(-decimals));
    };
    if places > 300 {
        return format!("{x:e}");
    }
    let text = format!("{x:.places$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

/// Words for several, the same for one. Only words that messages count are in the list.
const NOUNS: &[(&str, &str)] = &[
    ("vertices", "vertex"),
    ("faces", "face"),
    ("edges", "edge"),
    ("triangles", "triangle"),
    ("quads", "quad"),
    ("polygons", "polygon"),
    ("hexes", "hex"),
    ("cells", "cell"),
    ("corners", "corner"),
    ("nodes", "node"),
    ("elements", "element"),
    ("components", "component"),
    ("bodies", "body"),
    ("sheets", "sheet"),
    ("shells", "shell"),
    ("solids", "solid"),
    ("regions", "region"),
    ("patches", "patch"),
    ("pieces", "piece"),
    ("specks", "speck"),
    ("holes", "hole"),
    ("loops", "loop"),
    ("lines", "line"),
    ("limbs", "limb"),
    ("branches", "branch"),
    ("branchings", "branching"),
    ("segments", "segment"),
    ("extremities", "extremity"),
    ("cycles", "cycle"),
    ("tips", "tip"),
    ("discs", "disc"),
    ("cuts", "cut"),
    ("tracks", "track"),
    ("singularities", "singularity"),
    ("places", "place"),
    ("pairs", "pair"),
    ("points", "point"),
    ("labels", "label"),
    ("references", "reference"),
    ("bytes", "byte"),
    ("threads", "thread"),
    ("fields", "field"),
    ("entries", "entry"),
    ("values", "value"),
    ("ends", "end"),
    ("caps", "cap"),
    ("layers", "layer"),
    ("seconds", "second"),
    ("warnings", "warning"),
    ("features", "feature"),
    ("groups", "group"),
    ("materials", "material"),
    ("ids", "id"),
];
/// The verbs that follow them.
const VERBS: &[(&str, &str)] = &[
    ("are", "is"),
    ("were", "was"),
    ("have", "has"),
    ("do", "does"),
    ("lie", "lies"),
    ("use", "uses"),
    ("end", "ends"),
    ("join", "joins"),
    ("turn", "turns"),
    ("meet", "meets"),
    ("touch", "touches"),
    ("need", "needs"),
    ("form", "forms"),
    ("share", "shares"),
    ("stay", "stays"),
    ("differ", "differs"),
    ("refer", "refers"),
    ("come", "comes"),
    ("follow", "follows"),
];
/// Words between a number and its noun, at most.
const BETWEEN: usize = 3;
/// Words between a noun and its verb, at most.
const BEFORE_VERB: usize = 6;

/// A message in which what is counted agrees with its number: "1 limbs had no branch and were given one" becomes "1 limb
/// had no branch and was given one". Only a number 1 that begins the text, or follows one of `:;,(→`, counts something.
///
/// ```
/// use carreau::words::agreed;
/// assert_eq!(agreed("1 tagged edges do not exist in the mesh"), "1 tagged edge does not exist in the mesh");
/// assert_eq!(agreed("21 edges are left"), "21 edges are left");
/// ```
pub fn agreed(text: &str) -> String {
    let mut words: Vec<String> = text.split(' ').map(str::to_string).collect();
    let bare = |word: &str| word.trim_end_matches([',', ';', ':', '.', ')']).to_string();
    for k in 0..words.len() {
        let starts = k == 0 || words[k - 1].ends_with([':', ';', ',', '(', '→']) || words[k].starts_with('(');
        if !starts || words[k].trim_start_matches('(') != "1" {
            continue;
        }
        // What it counts stands in the same clause.
        let ends_clause = |n: usize| words[n].ends_with([',', ';', ':', '.']);
        let clause = (k + 1..words.len()).find(|&n| ends_clause(n)).map_or(words.len(), |n| n + 1);
        let noun = (k + 1..clause.min(k + 2 + BETWEEN)).find_map(|n| {
            let plain = bare(&words[n]);
            let (_, one) = NOUNS.iter().find(|(many, _)| *many == plain)?;
            Some((n, plain, *one))
        });
        let Some((n, plain, one)) = noun else { continue };
        words[n] = words[n].replacen(&plain, one, 1);
        for word in words.iter_mut().skip(n).take(1 + BEFORE_VERB) {
            let plain = bare(word);
            if let Some((_, verb)) = VERBS.iter().find(|(many, _)| *many == plain) {
                *word = word.replacen(&plain, verb, 1);
            }
            // Here the clause ends.
            if word.ends_with([',', ';', ':', '.']) {
                break;
            }
        }
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one() {
        for (many, one) in [
            ("1 limbs had no branch and were given one", "1 limb had no branch and was given one"),
            ("1 quads, 1 regions, rung 1", "1 quad, 1 region, rung 1"),
            ("torus: 6 triangles → 1 regions", "torus: 6 triangles → 1 region"),
            (
                "the file: 1 faces of fewer than 3 corners were left out",
                "the file: 1 face of fewer than 3 corners was left out",
            ),
            ("1 solid, 6 faces", "1 solid, 6 faces"),
            ("11 faces were left out", "11 faces were left out"),
            ("rung 1 edges", "rung 1 edges"),
            ("2 of 1 faces", "2 of 1 faces"),
        ] {
            assert_eq!(agreed(many), one);
        }
    }
}
