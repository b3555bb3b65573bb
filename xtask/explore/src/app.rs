//! The addresses of the server, and the threads that work for them.

use std::sync::Arc;
use std::time::Duration;

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::RepairReport;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::{CONTENT_LENGTH, CONTENT_TYPE};
use hyper::http::request;
use hyper::{Method, Request};
use map2aps::sampling;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde::{Serialize, de::DeserializeOwned};
use serde_json::json;
use tokio::sync::{mpsc, oneshot};

use crate::compare::compare;
use crate::coverage::Survey;
use crate::fault::Fault;
use crate::link::answer;
use crate::reply::{self, Parts, Reply};
use crate::request::{CityQuestion, CoverageQuestion, LinkQuestion, read};
use crate::stock::Stock;
use crate::ticket::{Lanes, Ticket};
use crate::{files, guard, page};

/// Largest body \[bytes\]: the drawn houses of a map are some ten kilobytes.
const MAX_BODY: usize = 1 << 18;

/// Time for a body to arrive \[s\].
const BODY_S: u64 = 10;

/// Places of each kind of terminal that the first ones are chosen from.
const FIRST: usize = 16;

/// Distance of the first receiver from the first transmitter, as near as there is one \[m\].
const FIRST_M: f64 = 60.0;

/// Blocks of cells that may wait for their reader.
const BLOCKS_AHEAD: usize = 4;

/// Number of a page, drawn by itself; its requests overtake each other.
const PAGE: &str = "x-page";

/// The server's state.
#[derive(Debug)]
pub struct App {
    stock: Arc<Stock>,
    lanes: Lanes,
    /// Threads for links, which are not to wait for the others.
    quick: ThreadPool,
    /// Threads for comparisons, coverage and files.
    slow: ThreadPool,
}

impl App {
    /// The state at the start.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(stock: Stock) -> Result<Arc<Self>, ThreadPoolBuildError> {
        // The panic itself is printed; the request's answer tells of it too.
        let pool = || ThreadPoolBuilder::new().panic_handler(|_| ()).build();
        Ok(Arc::new(Self {
            stock: Arc::new(stock),
            lanes: Lanes::default(),
            quick: pool()?,
            slow: pool()?,
        }))
    }

    /// Answers a request that came to `port`.
    pub async fn answer(&self, request: Request<Incoming>, port: u16) -> Reply {
        let answered = self.try_answer(request, port).await;
        answered.unwrap_or_else(|fault| reply::fault(&fault))
    }

    async fn try_answer(&self, request: Request<Incoming>, port: u16) -> Result<Reply, Fault> {
        let (head, body) = request.into_parts();
        guard::check(&head.method, &head.uri, &head.headers, port)?;
        let path = head.uri.path();
        if let Some(file) = page::file(path) {
            return must_be(&head, Method::GET).map(|()| file);
        }
        if path == "/api/maps" {
            must_be(&head, Method::GET)?;
            return Ok(reply::json(&self.maps()));
        }
        let kind = match path.strip_prefix("/api/") {
            Some("map") => "map",
            Some("link") => "link",
            Some("compare") => "compare",
            Some("coverage") => "coverage",
            _ if file_of(path).is_some() => "file",
            _ => return Err(Fault::NotFound),
        };
        must_be(&head, Method::POST)?;
        let ticket = self.lanes.enter(page_of(&head), kind);
        let held = ticket.held();
        let body = body_of(&head, body).await?;
        let reply = match kind {
            "map" => self.work(&self.quick, &body, ticket, map).await?,
            "link" => self.work(&self.quick, &body, ticket, answer).await?,
            "compare" => self.work(&self.slow, &body, ticket, compare).await?,
            "coverage" => {
                let question: CoverageQuestion = read(&body)?;
                return self.coverage(question, ticket, held).await;
            }
            _ => {
                let name = file_of(path).ok_or(Fault::NotFound)?.to_owned();
                let question: LinkQuestion = read(&body)?;
                let stock = Arc::clone(&self.stock);
                let make = move || files::make(&name, &stock, &question, &ticket);
                on(&self.slow, make).await?
            }
        };
        drop(held);
        Ok(reply)
    }

    fn maps(&self) -> impl Serialize + use<> {
        let maps = self.stock.maps();
        json!({ "source": maps.source.to_string(), "ids": maps.ids })
    }

    /// Computes an answer on some threads.
    async fn work<Q, A>(
        &self,
        pool: &ThreadPool,
        body: &[u8],
        ticket: Ticket,
        compute: fn(&Stock, &Q, &Ticket) -> Result<A, Fault>,
    ) -> Result<Reply, Fault>
    where
        Q: DeserializeOwned + Send + 'static,
        A: Serialize + 'static,
    {
        let question: Q = read(body)?;
        let stock = Arc::clone(&self.stock);
        on(pool, move || {
            Ok(reply::json(&compute(&stock, &question, &ticket)?))
        })
        .await
    }

    async fn coverage(
        &self,
        question: CoverageQuestion,
        ticket: Ticket,
        held: crate::ticket::Held,
    ) -> Result<Reply, Fault> {
        let stock = Arc::clone(&self.stock);
        let known = ticket.clone();
        let survey = on(&self.slow, move || Survey::new(&stock, &question, &known)).await?;
        let (sender, receiver) = mpsc::channel::<Bytes>(BLOCKS_AHEAD);
        self.slow.spawn(move || {
            survey.run(&ticket, |line| sender.blocking_send(line.into()).is_ok());
        });
        Ok(reply::parts(Parts::new(receiver, held)))
    }
}

/// Runs a job on some threads.
async fn on<T: Send + 'static>(
    pool: &ThreadPool,
    job: impl FnOnce() -> Result<T, Fault> + Send + 'static,
) -> Result<T, Fault> {
    let (sender, receiver) = oneshot::channel();
    pool.spawn(move || {
        let _ = sender.send(job());
    });
    // Nobody sends when the job has panicked.
    receiver.await.unwrap_or(Err(Fault::Broken))
}

/// The file that a path names.
fn file_of(path: &str) -> Option<&str> {
    path.strip_prefix("/api/file/")
        .filter(|name| files::is_file(name))
}

fn must_be(head: &request::Parts, method: Method) -> Result<(), Fault> {
    match head.method == method {
        true => Ok(()),
        false if method == Method::GET => Err(Fault::Method("GET")),
        false => Err(Fault::Method("POST")),
    }
}

/// The number of the page that asks; programs that give none are one page.
fn page_of(head: &request::Parts) -> u64 {
    let value = head.headers.get(PAGE).and_then(|value| value.to_str().ok());
    value.and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// Reads a body of a bounded size in a bounded time.
async fn body_of(head: &request::Parts, body: Incoming) -> Result<Bytes, Fault> {
    let media_type = head.headers.get(CONTENT_TYPE);
    if media_type.is_none_or(|media_type| media_type != reply::JSON) {
        return Err(Fault::MediaType);
    }
    let given = head.headers.get(CONTENT_LENGTH);
    let given = given.and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if given.unwrap_or(0).max(body.size_hint().lower()) > MAX_BODY as u64 {
        return Err(Fault::TooLarge(MAX_BODY));
    }
    let whole = Limited::new(body, MAX_BODY).collect();
    let read = tokio::time::timeout(Duration::from_secs(BODY_S), whole).await;
    let read = read.map_err(|_| Fault::Slow(BODY_S))?;
    let bytes = read.map_err(|error| match error.is::<LengthLimitError>() {
        true => Fault::TooLarge(MAX_BODY),
        false => Fault::Cut,
    })?;
    Ok(bytes.to_bytes())
}

/// A map for the page.
#[derive(Debug, Serialize)]
struct MapAnswer {
    area: [[f64; 2]; 2],
    /// Outlines of the united buildings \[m\].
    rings: Vec<Vec<[f64; 2]>>,
    houses: Vec<HouseAnswer>,
    /// Number of houses of the map as it was read: drawn ones are numbered from there.
    as_read: usize,
    walls: usize,
    /// Findings in all houses, and in those of the map as it was read.
    repairs: String,
    repairs_as_read: String,
    /// Places of the terminals at first.
    tx: Option<[f64; 2]>,
    rx: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct HouseAnswer {
    id: usize,
    rings: Vec<Vec<[f64; 2]>>,
    /// Findings in this house, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    repairs: Option<String>,
}

fn map(stock: &Stock, question: &CityQuestion, ticket: &Ticket) -> Result<MapAnswer, Fault> {
    ticket.check()?;
    let city = stock.city(question)?;
    let report = city.scene.report();
    let repairs_as_read = match question.houses.is_empty() {
        true => report.to_string(),
        false => {
            let as_read = CityQuestion {
                map: question.map,
                ..CityQuestion::default()
            };
            stock.city(&as_read)?.scene.report().to_string()
        }
    };
    let numbers = |ring: &Vec<DVec2>| ring.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let houses = city.houses.iter().enumerate().map(|(i, house)| {
        let repairs = report.repairs.iter().filter(|repair| repair.building == i);
        let own = RepairReport {
            repairs: repairs.copied().collect(),
        };
        let footprint = &house.footprint;
        let rings = std::iter::once(&footprint.outer).chain(&footprint.holes);
        HouseAnswer {
            id: house.id,
            rings: rings.map(numbers).collect(),
            repairs: (!own.is_clean()).then(|| own.to_string()),
        }
    });
    let seed = stock.maps().seed;
    let drawn = sampling::draw(&city.scene, seed, question.map, FIRST, 1..=FIRST).ok();
    // In the streets, if there is a choice: between two courtyards there is no path.
    let in_street = |&p: &DVec2| city.scene.courtyard_of(p).is_none();
    let first = |points: &[DVec2]| {
        points
            .iter()
            .copied()
            .find(in_street)
            .or(points.first().copied())
    };
    let tx = drawn.as_ref().and_then(|drawn| first(&drawn.tx));
    // Far from the transmitter there is often no path within the limits.
    let rx = drawn.as_ref().zip(tx).and_then(|(drawn, tx)| {
        let off = |p: &DVec2| (p.distance(tx) - FIRST_M).abs();
        let streets = drawn.rx.iter().copied().filter(in_street);
        let nearest = streets.min_by(|p, q| off(p).total_cmp(&off(q)));
        nearest.or(drawn.rx.first().copied())
    });
    Ok(MapAnswer {
        area: [city.area.min, city.area.max].map(|p| p.to_array()),
        rings: city.outlines.rings.iter().map(numbers).collect(),
        houses: houses.collect(),
        as_read: city.as_read,
        walls: city.scene.walls().len(),
        repairs: report.to_string(),
        repairs_as_read,
        tx: tx.map(|p| p.to_array()),
        rx: rx.map(|p| p.to_array()),
    })
}
