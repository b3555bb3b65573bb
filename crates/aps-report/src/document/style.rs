//! The style of all pages.

use crate::theme;

/// Most paths that a page can link to each other.
const LINKS: usize = 64;

const CSS: &str = "\
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,sans-serif}
main{max-width:1080px;margin:0 auto;padding:1.5rem 1rem 4rem}
h1{font-size:1.7rem;line-height:1.2;margin:.3rem 0 .8rem}
h2{font-size:1.25rem;margin:2.4rem 0 .6rem;padding-top:.6rem;border-top:1px solid var(--grid)}
h3{font-size:1.05rem;margin:1.8rem 0 .2rem}
p{max-width:72ch;margin:.6rem 0}
.lead{color:var(--soft)}
a{color:var(--accent)}
code{font:.9em ui-monospace,monospace;background:var(--panel);padding:.1em .3em;border-radius:3px;overflow-wrap:anywhere}
pre{overflow-x:auto}
nav ul{list-style:none;padding:0;margin:1rem 0;display:flex;flex-wrap:wrap;gap:.3rem 1.2rem}
figure{margin:1rem 0;width:100%}
figcaption{font-size:.875rem;line-height:1.4;color:var(--soft);margin-top:.3rem}
.picture{display:block;width:100%;height:auto}
.beside{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,420px),1fr));gap:0 2rem;align-items:start}
.scroll{overflow-x:auto;margin:1rem 0}
table{border-collapse:collapse;font-size:.9rem;line-height:1.35}
caption{text-align:left;color:var(--soft);padding-bottom:.4rem}
th,td{padding:.35rem .7rem;text-align:left;vertical-align:top;border-bottom:1px solid var(--grid)}
th{font-weight:600;border-bottom-color:var(--edge)}
.number{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td:first-child,th:first-child{padding-left:.2rem}
.chip{display:inline-block;min-width:1.7em;padding:0 .35em;border-radius:1em;text-align:center;font-weight:700;color:var(--paper)}
tr[data-path]{cursor:default}
tr[data-path]:hover,tr[data-path]:focus{background:var(--panel);outline:none}
.linked [data-path]{transition:opacity .12s}
small{font-size:.78rem;color:var(--soft)}
.pinned td:first-child,.pinned th:first-child{position:sticky;left:0;background:var(--paper);z-index:1;white-space:nowrap}
@media(max-width:760px){th,td{white-space:nowrap;padding:.35rem .4rem}.pinned td:first-child{white-space:normal;min-width:6.5rem}}
.pinned th{white-space:normal}
.scroll caption{position:sticky;left:0;max-width:min(72ch,calc(100vw - 2rem))}
@media print{.beside{display:block}}
";

/// The whole style of a page.
pub fn css() -> String {
    let mut css = theme::variables_css() + CSS + &theme::picture_css();
    // Pointing at a path, at its marker or at its row dims all other paths; no script is needed.
    for i in 1..=LINKS {
        css += &format!(
            ".linked:has([data-path=\"{i}\"]:is(:hover,:focus)) svg [data-path]:not([data-path=\"{i}\"]){{opacity:.12}}\
             .linked:has([data-path=\"{i}\"]:is(:hover,:focus)) tr[data-path=\"{i}\"]{{background:var(--panel)}}\n"
        );
    }
    css
}
