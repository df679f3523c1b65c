# Worlds in a container: docker build -t libgz . && docker run --rm libgz gazebo -n --steps 500 pioneer2at
FROM debian:12-slim AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc libc6-dev python3 python3-venv \
    && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN python3 -m venv /opt/libgz && /opt/libgz/bin/pip install --no-cache-dir "/src[view]"

FROM debian:12-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends libode8 libosmesa6 python3 \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home --uid 1000 libgz
COPY --from=build /opt/libgz /opt/libgz
ENV PATH=/opt/libgz/bin:$PATH PYTHONUNBUFFERED=1 USER=libgz
USER libgz
# The page of the view: docker run --rm -p 127.0.0.1:8080:8080 libgz gazebo --view --view-host 0.0.0.0 pioneer2at
EXPOSE 8080
WORKDIR /home/libgz
# Healthy while the server of id 0 steps, paused or not. The first wait may be for an old step.
HEALTHCHECK --interval=10s --timeout=9s --start-period=20s CMD ["python3", "-P", "-c", \
    "import libgz, sys; c = libgz.Client(0, 7); c.wait(timeout=3.0); sys.exit(not c.wait(timeout=3.0))"]
CMD ["gazebo", "pioneer2at"]
