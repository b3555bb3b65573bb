//! Connections.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use tokio_io_timeout::TimeoutStream;

use crate::app::App;
use crate::cache::{Cache, Maps};

/// Connections at a time; further ones wait.
const MAX_CONNECTIONS: usize = 64;

/// Time for the head of a request to arrive, and for the next request of a connection.
const HEAD: Duration = Duration::from_secs(30);

/// Time that an answer waits for somebody who does not read it: further connections wait as well.
const UNREAD: Duration = Duration::from_secs(30);

/// Largest head of a request \[bytes\]; hyper takes no less.
const MAX_HEAD: usize = 8192;

/// Error of serving the page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// A port that is taken or not allowed.
    #[error("cannot listen on port {port}; 0 takes a free one")]
    Port {
        /// The port asked for.
        port: u16,
        /// The answer of the system.
        source: io::Error,
    },
    /// Threads or sockets that the system refuses.
    #[error(transparent)]
    System(#[from] io::Error),
    /// Threads of a pool that cannot be started.
    #[error(transparent)]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

/// A server on the loopback address.
#[derive(Debug)]
pub struct Server {
    app: Arc<App>,
    listener: TcpListener,
    address: SocketAddr,
}

impl Server {
    /// Listens on a port of 127.0.0.1, to show maps; 0 takes a free one.
    ///
    /// # Errors
    /// A port that is taken or not allowed, and threads that cannot be started.
    pub fn bind(maps: Maps, port: u16) -> Result<Self, ServeError> {
        let app = App::new(Cache::new(maps)?)?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        let listener = listener.map_err(|source| ServeError::Port { port, source })?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            app,
            listener,
        })
    }

    /// Its address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Answers requests for as long as the process lives.
    ///
    /// # Errors
    /// Threads or sockets that the system refuses.
    pub fn serve(self) -> Result<(), ServeError> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()?;
        Ok(runtime.block_on(self.accept())?)
    }

    async fn accept(self) -> io::Result<()> {
        let listener = tokio::net::TcpListener::from_std(self.listener)?;
        let places = Arc::new(Semaphore::new(MAX_CONNECTIONS));
        loop {
            let place = Arc::clone(&places).acquire_owned().await;
            let Ok((stream, _)) = listener.accept().await else {
                // Too many open files, or a connection that has gone again: others may do.
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            };
            let app = Arc::clone(&self.app);
            let port = self.address.port();
            tokio::spawn(async move {
                // A connection that ends in an error ends, and that is all.
                let _ = connection(app, stream, port).await;
                drop(place);
            });
        }
    }
}

async fn connection(app: Arc<App>, stream: TcpStream, port: u16) -> hyper::Result<()> {
    // Answers are small and waited for: none is held back for a fuller packet.
    let _ = stream.set_nodelay(true);
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(UNREAD));
    let service = service_fn(|request| {
        let app = Arc::clone(&app);
        async move { hyper::Result::Ok(app.answer(request, port).await) }
    });
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD)
        .max_buf_size(MAX_HEAD)
        .serve_connection(TokioIo::new(Box::pin(stream)), service)
        .await
}
