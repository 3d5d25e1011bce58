# The command alone, without a system around it:
#
#   docker build -t meliora .
#   docker run --rm -v "$PWD:/work" meliora check model.prism preferences.pref
FROM rust:1.91-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
RUN cargo rustc --release --locked -p meliora --bin meliora -- -C strip=symbols -C target-feature=+crt-static

FROM scratch
COPY --from=build /source/target/release/meliora /usr/local/bin/meliora
COPY --from=build /source/models /models
WORKDIR /work
ENTRYPOINT ["/usr/local/bin/meliora"]
