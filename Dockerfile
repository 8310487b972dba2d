# geohue, its loops compiled ahead, for a user without rights.
#   docker build -t geohue .
#   docker run --rm -v "$PWD:/work" geohue segment rgb.png depth.png -o out
FROM python:3.11-slim AS build
COPY . /source
RUN python -m venv /opt/geohue \
 && /opt/geohue/bin/pip install --no-cache-dir "/source[clouds]" \
 && find /opt/geohue -name tests -type d -prune -exec rm -rf {} +

FROM python:3.11-slim
COPY --from=build /opt/geohue /opt/geohue
# One kind of machine code for all processors that the image may meet.
ENV PATH=/opt/geohue/bin:$PATH NUMBA_CACHE_DIR=/var/cache/geohue NUMBA_CPU_NAME=generic
RUN useradd --create-home geohue && install -d -o geohue /var/cache/geohue /work
USER geohue
RUN geohue warm
WORKDIR /work
ENTRYPOINT ["geohue"]
CMD ["--help"]
