//! The index of the demo: a section per room, a figure per model.

use serde::Serialize;

/// One room.
#[derive(Serialize)]
pub struct Section {
    pub title: &'static str,
    pub about: &'static str,
    pub figures: Vec<Figure>,
}

/// One model: a picture, what it shows, and files.
#[derive(Serialize)]
pub struct Figure {
    pub name: String,
    pub about: &'static str,
    pub caption: String,
    pub picture: String,
    /// The page to turn it on, with the scene.
    pub page: String,
    /// What they are, and their names in the folder.
    pub files: Vec<(&'static str, String)>,
}

const STYLE: &str = "\
    body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:72rem;padding:0 1rem;color:#1b2230;background:#fff}\
    section{display:grid;grid-template-columns:repeat(auto-fill,minmax(20rem,1fr));gap:2rem}\
    figure{margin:0}img{width:100%;border:1px solid #d5dae3;border-radius:6px}h3{margin:.5rem 0 0;font-size:1.1rem}\
    p{margin:.2rem 0}h2{margin:2rem 0 0}h2+p{margin-bottom:1rem}\
    @media(prefers-color-scheme:dark){body{background:#14181f;color:#dfe5ee}a{color:#8ab4f8}}";

/// The whole page.
pub fn html(sections: &[Section]) -> String {
    let body: String = sections.iter().map(section).collect();
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>carreau demo</title><style>{STYLE}</style><h1>carreau: triangles to structured models</h1>\
         <p>Click on a picture to turn the model, switch layers, and ask for the numbers of every element.</p>\n{body}</html>\n"
    )
}

fn section(section: &Section) -> String {
    let figures: String = section.figures.iter().map(|f| figure(f, section.title)).collect();
    format!("<h2>{}</h2><p>{}</p><section>\n{figures}</section>\n", section.title, section.about)
}

fn figure(f: &Figure, title: &str) -> String {
    let files: Vec<String> = f.files.iter().map(|(what, file)| format!("<a href=\"{file}\">{what}</a>")).collect();
    format!(
        "<figure><a href=\"{v}\"><img src=\"{p}\" alt=\"{title} of {n}\"></a><figcaption><h3>{n}</h3><p>{a}</p><p>{c}</p>\
         <p><a href=\"{v}\">look closer</a> · <a href=\"{p}\">picture</a> · {files}</p></figcaption></figure>\n",
        p = f.picture,
        v = f.page,
        n = f.name,
        a = f.about,
        c = f.caption,
        files = files.join(" · "),
    )
}
