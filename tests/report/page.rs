//! The page as a text: it needs nothing else, says the finding first, and its links lead somewhere.

use std::path::Path;

use super::with;
use replication::paper::published::Claims;
use replication::report::verdict::Verdict;

/// The page of the run.
fn page() -> String {
    let read = |report: &super::Report| {
        std::fs::read_to_string(report.folder.path().join("report/index.html")).unwrap()
    };
    with(read)
}

/// The values of an attribute.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let begin = format!(" {attribute}=\"");
    let rest = page.split(&*begin).skip(1);
    rest.map(|rest| rest.split('"').next().unwrap()).collect()
}

/// The text between two marks.
fn between<'a>(page: &'a str, begin: &str, end: &str) -> &'a str {
    let rest = page
        .split_once(begin)
        .unwrap_or_else(|| panic!("no {begin}"))
        .1;
    rest.split_once(end).unwrap_or_else(|| panic!("no {end}")).0
}

#[test]
fn the_page_needs_nothing_else() {
    let page = page();
    assert!(!page.contains("<script") && values(&page, "src").is_empty());
    for link in values(&page, "href") {
        let own = link.starts_with('#') || link.starts_with("../") || link == "data:,";
        assert!(own || link.starts_with("https://doi.org/"), "{link}");
    }
}

#[test]
fn links_lead_somewhere() {
    let page = page();
    let anchors = values(&page, "id");
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    for link in values(&page, "href") {
        if let Some(anchor) = link.strip_prefix('#') {
            assert!(anchors.contains(&anchor), "{link}");
        } else if let Some(file) = link.strip_prefix("../") {
            assert!(top.join(file).is_file(), "{link}");
        }
    }
}

#[test]
fn the_function_and_the_test_of_a_claim_are_where_it_says() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    for claim in Claims::committed().unwrap().iter() {
        let [function, test] = claim.sources.each_ref().map(|source| {
            let (file, name) = source.split_once("::").unwrap();
            let text = std::fs::read_to_string(top.join(file)).unwrap();
            let found = ["(", "<"]
                .iter()
                .any(|next| text.contains(&format!("fn {name}{next}")));
            assert!(found, "{}: {source} is not there", claim.id);
            let header = text.split(&format!("fn {name}(")).next().unwrap();
            header.trim_end().ends_with("#[test]")
        });
        // A property is stated by a macro, in which the attribute does not stand right before.
        assert!(
            !function && (test || claim.sources[1].contains("cubic.rs")),
            "{}",
            claim.id
        );
    }
}

#[test]
fn it_opens_with_the_finding_and_sets_symbols() {
    let page = page();
    let opening = between(&page, "<p class=\"verdict\">", "</p>");
    assert!(
        opening.contains("Fig. 8’s stick–slip is not a solution"),
        "{opening}"
    );
    assert!(
        page.contains("<i>μ</i><sub>0</sub>") && page.contains("<i>x</i><sub>1</sub><sup>3</sup>")
    );
    let claims = between(&page, "<table class=\"list cards\">", "</table>");
    for word in ["mu0", "x1", "xi6", "vp ", "lambda "] {
        // Names of claims are not set.
        let text = claims
            .split("<code>")
            .map(|part| part.rsplit("</code>").next().unwrap());
        assert!(
            !text.collect::<String>().contains(&format!(" {word}")),
            "{word}"
        );
    }
}

/// The text that a reader sees beside the figures, without names of files and claims.
fn visible(page: &str) -> String {
    let mut text = page.to_owned();
    for element in ["style", "svg", "code"] {
        let (begin, end) = (format!("<{element}"), format!("</{element}>"));
        let parts = text.split(&*begin);
        text = parts
            .map(|part| part.rsplit(&*end).next().unwrap())
            .collect();
    }
    let parts = text.split('<');
    parts.map(|part| part.rsplit('>').next().unwrap()).collect()
}

#[test]
fn powers_roots_and_indices_are_set_on_the_whole_page() {
    let text = visible(&page());
    assert!(text.contains("not a rare match; its reading"));
    let is_digit = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit());
    for mark in ["^", "sqrt(", "_k", "mu", "xi", "omega", "lambda"] {
        let found = text.match_indices(mark).find(|(at, _)| match mark {
            "sqrt(" | "_k" => true,
            _ => is_digit(&text[at + mark.len()..]),
        });
        let shown = found.map(|(at, _)| text[at..].chars().take(40).collect::<String>());
        assert_eq!(shown, None);
    }
}

#[test]
fn every_verdict_has_its_rows_and_its_filter() {
    let page = page();
    let claims = between(&page, "<table class=\"list cards\">", "</table>");
    with(|report| {
        for verdict in Verdict::ALL {
            let key = verdict.key();
            let rows = claims.matches(&format!("<tr class=\"{key}\"")).count();
            assert_eq!(rows, report.ledger.with(verdict), "{key}");
            let hides = format!(".claims:has(#only-{key}:checked) .list tbody tr:not(.{key})");
            assert!(page.contains(&hides), "{key}");
            assert!(page.contains(&format!("id=\"only-{key}\"")), "{key}");
            assert!(
                page.contains(&format!(".mark.{key}::before")) || key == "missed",
                "{key}"
            );
        }
    });
}

#[test]
fn every_figure_is_drawn_and_links_to_its_program_numbers_and_golden() {
    let page = page();
    let figures: Vec<&str> = page.split("<figure>").skip(1).collect();
    // Seven figures of the paper, the convergence and the scan.
    assert_eq!(figures.len(), 9);
    for figure in figures {
        let figure = figure.split("</figure>").next().unwrap();
        assert!(between(figure, "<title", "</title>").len() > 10);
        assert!(between(figure, "<desc", "</desc>").len() > 100);
        let links = values(figure, "href");
        let wanted = [
            ("../src/bin/", ".rs"),
            ("../figures/", ".csv"),
            ("../golden/", ".snap"),
        ];
        for (folder, extension) in wanted {
            let is = |link: &&&str| link.starts_with(folder) && link.ends_with(extension);
            assert_eq!(links.iter().filter(is).count(), 1, "{folder}: {links:?}");
        }
    }
}

#[test]
fn figs_10_to_12_have_a_row_each() {
    let page = page();
    let section = between(&page, "<h2 id=\"readings\">", "</section>");
    assert_eq!(
        between(section, "<tbody>", "</tbody>")
            .matches("<tr>")
            .count(),
        3
    );
}
