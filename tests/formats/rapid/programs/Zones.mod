MODULE Zones
    ! Zones, conveyors, several robots: what RobotWare knows, never run.
    VAR shapedata v;
    VAR wztemporary z:=[0];
    PERS wobjdata w;
    VAR syncident id;
    PERS tasks all{2}:=[["A"],["B"]];
    VAR robtarget p;

    PROC main()
        WZBoxDef\Inside,v,[0,0,0],[1,1,1];
        WZDOSet\Temp,z\Inside,v,doX,1;
        WZFree z;
        ActUnit CNV1;
        WaitWObj w\RelDist:=10;
        DropWObj w;
        SyncMoveOn id,all\TimeOut:=60;
        MoveL p\ID:=10,v100,z10,tool0\WObj:=w;
        SyncMoveOff id;
        WaitSyncTask id,all;
        IndAMove STN_1,2\ToAbsNum:=90,20;
        PDispOn\Rot\ExeP:=p,p,tool0;
        PDispOff;
        EOffsSet [0,0,0,0,0,0];
        StorePath;
        RestoPath;
        StartMove;
    ENDPROC
ENDMODULE
